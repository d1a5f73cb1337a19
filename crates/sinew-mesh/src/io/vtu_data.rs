//! The bytes of a VTU array: base64 or raw, plain or in zlib blocks.

use super::cursor::{Endian, error_at, excerpt};
use super::number::NumberType;
use crate::{FieldValues, MeshError, Problem};
use base64::{Engine, engine::general_purpose::STANDARD};
use flate2::read::ZlibDecoder;
use std::io::Read;

/// The largest factor by which deflate can shrink data (zlib's "technical details"), so a
/// block that declares more is broken and nothing is allocated for it.
const MOST_DEFLATE: usize = 1032;

/// What the file's header says about all its arrays.
#[derive(Clone, Copy)]
pub(crate) struct Layout {
    pub endian: Endian,
    /// Sizes have 64 bits instead of 32.
    pub wide_header: bool,
    pub zlib: bool,
}

/// Bytes read in order from base64 text or as they are.
pub(crate) struct Source<'a> {
    file: &'a str,
    /// Where `data` begins in the file.
    at: usize,
    data: &'a [u8],
    position: usize,
    base64: bool,
    /// Decoded bytes of the last base64 group that were not asked for yet.
    ready: Vec<u8>,
}

impl<'a> Source<'a> {
    pub(super) fn base64(file: &'a str, at: usize, data: &'a [u8]) -> Self {
        Source { file, at, data, position: 0, base64: true, ready: Vec::new() }
    }

    pub(super) fn raw(file: &'a str, at: usize, data: &'a [u8]) -> Self {
        Source { file, at, data, position: 0, base64: false, ready: Vec::new() }
    }

    fn error(&self, problem: Problem) -> MeshError {
        // Inline text may have been gathered around nested elements, so its start is the
        // closest place that is known for sure.
        let within = if self.base64 { 0 } else { self.position };
        error_at(self.file, self.at + within, problem)
    }

    /// The next `count` bytes.
    fn take(&mut self, count: usize, what: &'static str) -> Result<Vec<u8>, MeshError> {
        let left = self.data.len() - self.position;
        let available = if self.base64 { self.ready.len() + left / 4 * 3 } else { left };
        if count > available {
            return Err(self.error(Problem::CutOff { what, needed: count as u128, available }));
        }
        if !self.base64 {
            let taken = self.data[self.position..self.position + count].to_vec();
            self.position += count;
            return Ok(taken);
        }
        while self.ready.len() < count {
            self.decode_group(what)?;
        }
        let rest = self.ready.split_off(count);
        Ok(std::mem::replace(&mut self.ready, rest))
    }

    /// Decodes four characters. Padding may stand between groups, because some programs
    /// encode the header and the data of an array one after the other.
    fn decode_group(&mut self, what: &'static str) -> Result<(), MeshError> {
        let mut group = [0; 4];
        for slot in &mut group {
            let rest = &self.data[self.position..];
            let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
            let Some(&character) = rest.get(blanks) else {
                let needed = self.ready.len() as u128 + 1;
                return Err(self.error(Problem::CutOff {
                    what,
                    needed,
                    available: self.ready.len(),
                }));
            };
            self.position += blanks + 1;
            *slot = character;
        }
        let decoded = STANDARD.decode(group);
        self.ready
            .extend(decoded.map_err(|_| self.error(Problem::Base64 { found: excerpt(&group) }))?);
        Ok(())
    }

    /// `count` sizes of the header.
    fn sizes(&mut self, count: usize, layout: Layout) -> Result<Vec<usize>, MeshError> {
        let kind = if layout.wide_header { NumberType::U64 } else { NumberType::U32 };
        let what = "sizes in the header of an array";
        let bytes = self.take(count.saturating_mul(kind.size()), what)?;
        let too_large = |value| Problem::Range { what, value, least: 0, most: i64::MAX };
        match kind.decode(&bytes, layout.endian) {
            Ok(FieldValues::Integer(sizes)) => {
                Ok(sizes.iter().map(|&size| size as usize).collect())
            }
            _ => Err(self.error(too_large(-1))),
        }
    }
}

/// Reads the numbers of an array; `expected` is how many there must be, if known.
pub(crate) fn read_array(
    mut source: Source<'_>,
    layout: Layout,
    kind: NumberType,
    expected: Option<usize>,
) -> Result<FieldValues, MeshError> {
    if expected == Some(0) {
        return Ok(kind.decode(&[], layout.endian).unwrap_or(FieldValues::Integer(vec![])));
    }
    let expected = expected.map(|count| count.saturating_mul(kind.size()));
    let bytes = if layout.zlib {
        inflate(&mut source, layout, expected)?
    } else {
        let size = source.sizes(1, layout)?[0];
        check_size(&source, size, expected)?;
        source.take(size, "numbers of an array")?
    };
    kind.decode(&bytes, layout.endian).map_err(|_| {
        let (expected, found) = ("integers below 2^63", "a larger one".into());
        source.error(Problem::Expected { expected, found })
    })
}

fn check_size(source: &Source<'_>, found: usize, expected: Option<usize>) -> Result<(), MeshError> {
    match expected {
        Some(expected) if expected != found => {
            let what = "bytes of an array".into();
            Err(source.error(Problem::Count { what, expected, found }))
        }
        _ => Ok(()),
    }
}

/// Blocks of equal size, the last one shorter unless its size is given as 0.
fn inflate(
    source: &mut Source<'_>,
    layout: Layout,
    expected: Option<usize>,
) -> Result<Vec<u8>, MeshError> {
    let head = source.sizes(3, layout)?;
    let (blocks, full, last) = (head[0], head[1], head[2]);
    let compressed = source.sizes(blocks, layout)?;
    let last = if last == 0 { full } else { last };
    let total = full.saturating_mul(blocks.saturating_sub(1)).saturating_add(last);
    check_size(source, if blocks == 0 { 0 } else { total }, expected)?;
    let mut bytes = Vec::new();
    for (block, &size) in compressed.iter().enumerate() {
        let declared = if block + 1 == blocks { last } else { full };
        let data = source.take(size, "compressed blocks")?;
        let broken = |source: &Source<'_>| source.error(Problem::Compression { block, declared });
        if declared > size.saturating_mul(MOST_DEFLATE) {
            return Err(broken(source));
        }
        let before = bytes.len();
        // One byte more than declared shows that there is too much, and no more is kept.
        let mut decoder = ZlibDecoder::new(data.as_slice()).take(declared as u64 + 1);
        let read = decoder.read_to_end(&mut bytes);
        if read.is_err() || bytes.len() - before != declared {
            return Err(broken(source));
        }
    }
    Ok(bytes)
}

/// The numbers of an array written as text.
pub(crate) fn ascii(
    file: &str,
    at: usize,
    kind: NumberType,
    text: &[u8],
) -> Result<FieldValues, MeshError> {
    let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    let bad = |word: &[u8]| {
        let found = excerpt(word);
        error_at(file, at, Problem::Expected { expected: "a number of the array's type", found })
    };
    let text = |word| str::from_utf8(word).map_err(|_| bad(word));
    if kind.is_float() {
        let numbers = words.map(|word| text(word)?.parse().map_err(|_| bad(word)));
        Ok(FieldValues::Float(numbers.collect::<Result<_, _>>()?))
    } else {
        let numbers = words.map(|word| text(word)?.parse().map_err(|_| bad(word)));
        Ok(FieldValues::Integer(numbers.collect::<Result<_, _>>()?))
    }
}
