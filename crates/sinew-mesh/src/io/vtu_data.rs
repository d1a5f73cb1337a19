//! The bytes of a VTU array: base64 or raw, plain or in zlib blocks.

use super::cursor::{Cursor, Encoding, Result, excerpt};
use super::number::NumberType;
use crate::{FieldValues, Refusal};
use base64::{Engine, engine::general_purpose::STANDARD};
use flate2::read::ZlibDecoder;
use std::io::Read;

/// The largest factor by which deflate can shrink data (zlib's "technical details"), so a
/// block that declares more is broken and nothing is allocated for it.
const MOST_DEFLATE: usize = 1032;

/// Properties of all arrays, from the file's header.
#[derive(Clone, Copy, Default)]
pub(crate) struct Layout {
    pub encoding: Encoding,
    /// Sizes have 64 bits instead of 32.
    pub wide_header: bool,
    pub zlib: bool,
}

/// Bytes read in order from base64 text or as they are.
pub(crate) struct Source<'a> {
    /// Offset of `data` in the file.
    at: usize,
    data: &'a [u8],
    position: usize,
    base64: bool,
    layout: Layout,
    /// Decoded bytes of the last base64 group that were not asked for yet.
    ready: Vec<u8>,
}

impl<'a> Source<'a> {
    pub(super) fn new(at: usize, data: &'a [u8], base64: bool, layout: Layout) -> Self {
        Source { at, data, position: 0, base64, layout, ready: Vec::new() }
    }

    /// The bytes behind the underscore of the section of appended data, where there is one. Arrays begin in it by [`Source::starting`],
    /// which gives them their layout.
    pub(super) fn appended(at: usize, section: &'a [u8]) -> Result<Option<Self>> {
        if section.is_empty() {
            return Ok(None);
        }
        let mut cursor = Cursor::new(section);
        let tag = cursor.skip_past(b">", "the end of the AppendedData tag")?;
        cursor.skip_past(b"_", "the underscore before appended data")?;
        let (start, base64) = (cursor.position, tag.windows(6).any(|part| part == b"base64"));
        Ok(Some(Self::new(at + start, &section[start..], base64, Layout::default())))
    }

    /// Appended data from an offset on.
    pub(super) fn starting(&self, offset: usize, layout: Layout) -> Result<Self> {
        let value = i64::try_from(offset).unwrap_or(i64::MAX);
        let bounds = [0, self.data.len() as i64];
        Refusal::require_within("the offset of an appended array", value, bounds)?;
        Ok(Self::new(self.at + offset, &self.data[offset..], self.base64, layout))
    }

    /// Offset of the next byte in the file.
    pub(super) fn place(&self) -> usize {
        // Inline text may be joined from pieces around nested elements, so that only its start is known.
        self.at + if self.base64 { 0 } else { self.position }
    }

    /// The next `count` bytes.
    fn take(&mut self, count: usize, what: &'static str) -> Result<Vec<u8>> {
        let left = self.data.len() - self.position;
        let available = if self.base64 { self.ready.len() + left / 4 * 3 } else { left };
        Refusal::require_bytes(what, count as u128, available)?;
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
    fn decode_group(&mut self, what: &'static str) -> Result<()> {
        let mut group = [0; 4];
        for slot in &mut group {
            let rest = &self.data[self.position..];
            let blanks = rest.iter().take_while(|b| b.is_ascii_whitespace()).count();
            let Some(&character) = rest.get(blanks) else {
                let available = self.ready.len();
                return Err(Refusal::cut_off(what, available as u128 + 1, available));
            };
            self.position += blanks + 1;
            *slot = character;
        }
        let decoded = STANDARD.decode(group);
        let found = || format!("found `{}` in base64 data", excerpt(&group).escape_debug());
        self.ready.extend(decoded.map_err(|_| damaged(found()))?);
        Ok(())
    }

    /// `count` sizes of the header.
    fn sizes(&mut self, count: usize) -> Result<Vec<usize>> {
        let kind = if self.layout.wide_header { NumberType::U64 } else { NumberType::U32 };
        let what = "sizes in the header of an array";
        let bytes = self.take(count.saturating_mul(kind.size()), what)?;
        match kind.decode(&bytes, self.layout.encoding) {
            Ok(FieldValues::Integer(sizes)) => Ok(sizes.iter().map(|&n| n as usize).collect()),
            // A size of 2^63 or more.
            _ => Refusal::require_within(what, -1, [0, i64::MAX]).map(|()| Vec::new()),
        }
    }
}

/// Reads the numbers of an array; `expected` is how many there must be, if known.
pub(crate) fn read_array(
    source: &mut Source<'_>,
    kind: NumberType,
    expected: Option<usize>,
) -> Result<FieldValues> {
    let layout = source.layout;
    if expected == Some(0) {
        return Ok(kind.decode(&[], layout.encoding).unwrap_or(FieldValues::Integer(vec![])));
    }
    let expected = expected.map(|count| count.saturating_mul(kind.size()));
    let bytes = if layout.zlib {
        inflate(source, expected)?
    } else {
        let size = source.sizes(1)?[0];
        check_size(size, expected)?;
        source.take(size, "numbers of an array")?
    };
    let too_large = |_| Refusal::expected("integers below 2^63", "a larger one");
    kind.decode(&bytes, layout.encoding).map_err(too_large)
}

/// Numbers that no writer has written.
fn damaged(what: String) -> Refusal {
    Refusal(format!("{what}; the file is damaged: export or copy it again"))
}

fn check_size(found: usize, expected: Option<usize>) -> Result<()> {
    Refusal::require_count("bytes of an array", expected.unwrap_or(found), found)
}

/// Blocks of equal size, the last one shorter unless its size is given as 0.
fn inflate(source: &mut Source<'_>, expected: Option<usize>) -> Result<Vec<u8>> {
    let head = source.sizes(3)?;
    let (blocks, full, last) = (head[0], head[1], head[2]);
    let compressed = source.sizes(blocks)?;
    let last = if last == 0 { full } else { last };
    let total = full.saturating_mul(blocks.saturating_sub(1)).saturating_add(last);
    check_size(if blocks == 0 { 0 } else { total }, expected)?;
    let mut bytes = Vec::new();
    for (block, &size) in compressed.iter().enumerate() {
        let declared = if block + 1 == blocks { last } else { full };
        let data = source.take(size, "compressed blocks")?;
        let what = format!("zlib block {block} must decompress to {declared} bytes, but does not");
        let broken = Err(damaged(what));
        if declared > size.saturating_mul(MOST_DEFLATE) {
            return broken;
        }
        let before = bytes.len();
        // One byte more than declared shows that there is too much, and no more is kept.
        let mut decoder = ZlibDecoder::new(data.as_slice()).take(declared as u64 + 1);
        let read = decoder.read_to_end(&mut bytes);
        if read.is_err() || bytes.len() - before != declared {
            return broken;
        }
    }
    Ok(bytes)
}

/// The numbers of an array written as text.
pub(crate) fn ascii(kind: NumberType, text: &[u8]) -> Result<FieldValues> {
    let words = text.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
    kind.parse(words.map(Ok), "a number of the array's type")
}
