//! A position in the bytes of a file, shared by the readers of text and binary formats.

use super::number::NumberType;
use crate::{Element, FieldValues, MeshError, Place, Refusal};
use std::fmt::Display;
use std::path::Path;
use std::str::FromStr;

/// Place and reason of a file that cannot be read.
pub(crate) type Fault = (Place, Refusal);

/// A piece of a message.
pub(super) type What = &'static str;

/// Result of a reader.
pub(super) type Result<T, E = Refusal> = std::result::Result<T, E>;

/// Encoding of the numbers in a file: text, or binary by the order of bytes.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) enum Encoding {
    #[default]
    Text,
    Little,
    Big,
}

/// Reads a file from front to back; never past its end, never more than its bytes can hold.
#[derive(Default)]
pub(crate) struct Cursor<'a> {
    bytes: &'a [u8],
    /// Position that the next item is read from.
    pub position: usize,
    /// Start of the last item, which errors point to.
    item: usize,
    /// Encoding of numbers; keywords are always text.
    pub encoding: Encoding,
}

/// A file's name in errors and its bytes.
pub(super) fn load(path: &Path) -> Result<(String, Vec<u8>), MeshError> {
    let failed = |source| MeshError::File { path: path.into(), source };
    Ok((path.display().to_string(), std::fs::read(path).map_err(failed)?))
}

/// Writes a file.
pub(crate) fn save(path: &Path, bytes: &[u8]) -> Result<(), MeshError> {
    let failed = |source| MeshError::File { path: path.into(), source };
    std::fs::write(path, bytes).map_err(failed)
}

/// Longest piece of a file that an error repeats, in characters.
const EXCERPT: usize = 40;

/// A file without the byte-order mark that some editors put before a text in UTF-8.
pub(crate) fn without_mark(bytes: &[u8]) -> &[u8] {
    bytes.strip_prefix(b"\xef\xbb\xbf").unwrap_or(bytes)
}

/// Text in UTF-8, or else in Latin-1, so that names of other programs stay apart.
pub fn text_of(bytes: &[u8]) -> String {
    let latin = |_| bytes.iter().map(|&byte| char::from(byte)).collect();
    str::from_utf8(bytes).map_or_else(latin, String::from)
}

/// The start of a text as errors show it.
pub(crate) fn excerpt(text: &[u8]) -> String {
    text_of(text).chars().take(EXCERPT).collect()
}

impl Refusal {
    /// Text found in the place of something else.
    pub(super) fn expected(expected: What, found: impl AsRef<[u8]>) -> Self {
        let found = excerpt(found.as_ref());
        let found = found.escape_debug();
        Self(format!("expected {expected}, found `{found}`; correct it or export the file again"))
    }

    /// A required part that is missing.
    pub(super) fn missing(expected: What) -> Self {
        Self(format!("expected {expected}, which is missing; export the file again with it"))
    }

    /// A file that ends before the numbers it declares.
    pub(super) fn cut_off(what: What, needed: u128, available: usize) -> Self {
        Self(format!(
            "{what}: only {available} of {needed} bytes are left in the file; the declared count is wrong or \
             the file was cut off: export or copy it again"
        ))
    }

    /// A mesh without cells.
    pub(super) fn no_cells(wanted: &Element) -> Self {
        Self(format!("the mesh has no {}; export the file with its cells", wanted.plural))
    }

    /// A name that files cannot hold or that is taken for the encoding of sets.
    pub(super) fn name(name: &str) -> Self {
        Self(format!(
            "name `{}` cannot be written; use a non-empty name without control characters that \
             does not start with `node_set:`, `facet_set:` or `cell_set:`",
            name.escape_debug()
        ))
    }

    /// Refuses a number or name that stood in the file before, for something else.
    pub(super) fn unless_used<T>(
        before: Option<T>,
        expected: What,
        found: impl ToString,
    ) -> Result<()> {
        before.map_or(Ok(()), |_| Err(Self::expected(expected, found.to_string())))
    }

    /// Requires that what was found is what the format has there.
    pub(super) fn require(is_it: bool, expected: What, found: impl AsRef<[u8]>) -> Result<()> {
        is_it.then_some(()).ok_or_else(|| Self::expected(expected, found))
    }

    /// Requires a part of the file.
    pub(super) fn require_part(is_there: bool, expected: What) -> Result<()> {
        is_there.then_some(()).ok_or_else(|| Self::missing(expected))
    }

    /// Requires bytes that a declared count needs.
    pub(super) fn require_bytes(what: What, needed: u128, available: usize) -> Result<()> {
        let enough = needed <= available as u128;
        enough.then_some(()).ok_or_else(|| Self::cut_off(what, needed, available))
    }

    /// Requires an integer within bounds, least and most.
    pub(super) fn require_within(what: What, value: i64, bounds: [i64; 2]) -> Result<()> {
        let [least, most] = bounds;
        let inside = (least..=most).contains(&value);
        inside.then_some(()).ok_or_else(|| {
            Self(format!(
                "{what} is {value}, which is outside {least}..={most}; export the file again"
            ))
        })
    }

    /// Requires a count to be what another one says.
    pub(super) fn require_count(what: impl Display, expected: usize, found: usize) -> Result<()> {
        let equal = expected == found;
        equal.then_some(()).ok_or_else(|| {
            Self(format!(
                "{what}: expected {expected} of them, found {found}; export the file again"
            ))
        })
    }

    /// Content of a kind that cannot be read, and the advice what to do.
    pub(super) fn unsupported(what: What, value: impl Into<String>, advice: What) -> Self {
        Self(format!("{what} `{}` cannot be read; {advice}", value.into().escape_debug()))
    }
}

/// A word as a number.
pub(super) fn number<T: FromStr>(word: &[u8], expected: What) -> Result<T> {
    let number = str::from_utf8(word).ok().and_then(|text| text.parse().ok());
    number.ok_or_else(|| Refusal::expected(expected, word))
}

impl<'a> Cursor<'a> {
    /// At the start of a file, behind its byte-order mark; places count that as well.
    pub(super) fn new(bytes: &'a [u8]) -> Self {
        let start = bytes.len() - without_mark(bytes).len();
        Cursor { bytes, position: start, item: start, encoding: Encoding::Text }
    }

    /// A problem with the last item read.
    pub(super) fn fault(&self, problem: Refusal) -> Fault {
        (self.place(self.item), problem)
    }

    /// Start of the next item.
    pub(super) fn here(&self) -> Place {
        self.place(self.position)
    }

    /// The place of a byte.
    pub(super) fn place(&self, byte: usize) -> Place {
        let line = || 1 + self.bytes[..byte].iter().filter(|&&b| b == b'\n').count();
        Place { byte, line: (self.encoding == Encoding::Text).then(line) }
    }

    fn rest(&self) -> &'a [u8] {
        &self.bytes[self.position..]
    }

    pub(super) fn skip_whitespace(&mut self) {
        let blank = self.rest().iter().take_while(|b| b.is_ascii_whitespace()).count();
        self.position += blank;
    }

    /// The rest of the line without surrounding blanks, or `None` at the end of the file.
    pub(super) fn line(&mut self) -> Option<&'a [u8]> {
        self.item = self.position;
        let rest = self.rest();
        if rest.is_empty() {
            return None;
        }
        let length = rest.iter().position(|&b| b == b'\n').unwrap_or(rest.len());
        self.position = (self.position + length + 1).min(self.bytes.len());
        Some(rest[..length].trim_ascii())
    }

    /// The rest of the line as text.
    pub(super) fn text_line(&mut self, expected: What) -> Result<String> {
        self.line().map(text_of).ok_or_else(|| Refusal::missing(expected))
    }

    /// The next word, or `None` at the end of the file.
    pub(super) fn word(&mut self) -> Option<&'a [u8]> {
        self.skip_whitespace();
        self.item = self.position;
        let rest = self.rest();
        let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
        self.position += length;
        (length > 0).then(|| &rest[..length])
    }

    /// The next word as text.
    pub(super) fn text(&mut self, expected: What) -> Result<&'a str> {
        let word = self.word().ok_or_else(|| Refusal::missing(expected))?;
        str::from_utf8(word).map_err(|_| Refusal::expected(expected, word))
    }

    /// The next word as a number, whatever the encoding.
    pub(super) fn parse<T: FromStr>(&mut self, expected: What) -> Result<T> {
        number(self.word().ok_or_else(|| Refusal::missing(expected))?, expected)
    }

    /// Reads a word that must be this one, in small or capital letters.
    pub(super) fn keyword(&mut self, keyword: &'static str) -> Result<()> {
        let word = self.text(keyword)?;
        Refusal::require(word.eq_ignore_ascii_case(keyword), keyword, word)
    }

    /// Reads up to and beyond `end`; what comes before it is returned.
    pub(super) fn skip_past(&mut self, end: &[u8], expected: What) -> Result<&'a [u8]> {
        self.item = self.position;
        let rest = self.rest();
        let found = rest.windows(end.len()).position(|window| window == end);
        let length = found.ok_or_else(|| Refusal::missing(expected))?;
        self.position += length + end.len();
        Ok(&rest[..length])
    }

    /// The next `count` bytes.
    pub(super) fn take(&mut self, count: usize, what: What) -> Result<&'a [u8]> {
        self.item = self.position;
        Refusal::require_bytes(what, count as u128, self.rest().len())?;
        let taken = &self.rest()[..count];
        self.position += count;
        Ok(taken)
    }

    /// `count` numbers in the cursor's encoding; a declared count that the rest of the file cannot hold is refused before
    /// anything is allocated for it.
    pub(super) fn numbers(
        &mut self,
        kind: NumberType,
        count: usize,
        what: What,
    ) -> Result<FieldValues> {
        let is_text = self.encoding == Encoding::Text;
        // In text a digit and a separator each, which only the last may lack.
        let texts = (2 * count as u128).saturating_sub(1);
        let needed = if is_text { texts } else { count as u128 * kind.size() as u128 };
        Refusal::require_bytes(what, needed, self.rest().len())?;
        if is_text {
            let word = |_| self.word().ok_or_else(|| Refusal::missing(what));
            return kind.parse((0..count).map(word), what);
        }
        let bytes = self.take(count * kind.size(), what)?;
        kind.decode(bytes, self.encoding).map_err(|index| {
            self.item += index * kind.size();
            Refusal::expected("an integer below 2^63", b"a larger one")
        })
    }

    /// `count` integers in the cursor's encoding.
    pub(super) fn integers(
        &mut self,
        kind: NumberType,
        count: usize,
        what: What,
    ) -> Result<Vec<i64>> {
        match self.numbers(kind, count, what)? {
            FieldValues::Integer(values) => Ok(values),
            FieldValues::Float(_) => Err(Refusal::expected("integers", b"real numbers")),
        }
    }

    /// `count` real numbers in the cursor's encoding; integers are widened.
    pub(super) fn reals(&mut self, kind: NumberType, count: usize, what: What) -> Result<Vec<f64>> {
        Ok(match self.numbers(kind, count, what)? {
            FieldValues::Float(values) => values,
            FieldValues::Integer(values) => values.into_iter().map(|v| v as f64).collect(),
        })
    }

    /// One integer in the cursor's encoding.
    pub(super) fn integer(&mut self, kind: NumberType, what: What) -> Result<i64> {
        if self.encoding == Encoding::Text {
            self.skip_whitespace();
        }
        self.item = self.position;
        Ok(self.integers(kind, 1, what)?[0])
    }

    /// One integer that counts something.
    pub(super) fn count(&mut self, kind: NumberType, what: What) -> Result<usize> {
        let value = self.integer(kind, what)?;
        Refusal::require_within(what, value, [0, i64::MAX])?;
        Ok(value as usize)
    }
}
