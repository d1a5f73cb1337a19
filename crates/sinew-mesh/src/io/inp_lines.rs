//! Lines of Abaqus and CalculiX files: keywords with their options, and the data behind them.

use super::cursor::{Cursor, Fault, Result};
use super::inp_sets::Scope;
use crate::Problem;
use std::cell::Cell;

/// A keyword with its options and lines of data.
pub(super) struct Block<'a> {
    /// Byte at which the keyword's line begins.
    pub at: usize,
    /// Byte of the line that is being read, which errors point to; one for all blocks.
    pub place: &'a Cell<usize>,
    /// Level of its names.
    pub scope: Scope,
    /// Keyword in capitals, without its asterisk.
    pub keyword: String,
    /// Options in capitals, each with its value.
    options: Vec<(String, &'a [u8])>,
    /// Lines of data, each with the byte at which it begins.
    lines: Vec<(usize, &'a [u8])>,
}

/// A name as it is compared and as it is shown: capitals matter in quotation marks only.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct Name {
    pub key: String,
    pub shown: String,
}

impl Name {
    pub(super) fn new(word: &[u8]) -> Self {
        let quoted = word.strip_prefix(b"\"").and_then(|word| word.strip_suffix(b"\""));
        let shown = String::from_utf8_lossy(quoted.unwrap_or(word)).into_owned();
        Self { key: if quoted.is_some() { shown.clone() } else { shown.to_uppercase() }, shown }
    }
}

/// Flags that may stand alone on a line that continues a keyword.
const FLAGS: [&[u8]; 3] = [b"GENERATE", b"INTERNAL", b"UNSORTED"];

/// All blocks of a file.
pub(super) fn blocks<'a>(
    cursor: &mut Cursor<'a>,
    place: &'a Cell<usize>,
) -> Result<Vec<Block<'a>>, Fault> {
    let mut blocks: Vec<Block<'a>> = Vec::new();
    // Whether the last line was a keyword's that ends with a comma.
    let mut open = false;
    loop {
        let at = cursor.position;
        let Some(line) = cursor.line() else { return Ok(blocks) };
        if line.is_empty() || line.starts_with(b"**") {
            continue;
        }
        let ends_open = line.ends_with(b",");
        if let Some(keyword) = line.strip_prefix(b"*") {
            blocks.push(Block::new(at, place, keyword));
            open = ends_open;
            continue;
        }
        let Some(block) = blocks.last_mut() else {
            let found = "a line without a keyword before it";
            return Err(cursor.fault(Problem::expected("a keyword such as *NODE", found)));
        };
        if open && continues(line) {
            block.options.extend(options(fields(line)));
            open = ends_open;
        } else {
            block.lines.push((at, line));
            open = false;
        }
    }
}

/// Whether a line behind a keyword that ends with a comma has more options; some programs end all lines with one.
fn continues(line: &[u8]) -> bool {
    let first = fields(line).next().unwrap_or_default().to_ascii_uppercase();
    first.contains(&b'=') || FLAGS.contains(&first.as_slice())
}

/// Words between commas, without blanks around them; commas in quotation marks do not count.
pub(super) fn fields(line: &[u8]) -> impl Iterator<Item = &[u8]> {
    let mut quoted = false;
    let separates = move |&byte: &u8| {
        quoted ^= byte == b'"';
        byte == b',' && !quoted
    };
    line.split(separates).map(<[u8]>::trim_ascii)
}

/// A word in capitals with single blanks.
fn capitals(word: &[u8]) -> String {
    let text = String::from_utf8_lossy(word).to_uppercase();
    text.split_whitespace().collect::<Vec<_>>().join(" ")
}

fn options<'a>(fields: impl Iterator<Item = &'a [u8]>) -> impl Iterator<Item = (String, &'a [u8])> {
    fields.filter(|field| !field.is_empty()).map(|field| {
        let mut parts = field.splitn(2, |&byte| byte == b'=');
        let key = capitals(parts.next().unwrap_or_default());
        (key, parts.next().unwrap_or_default().trim_ascii())
    })
}

impl<'a> Block<'a> {
    fn new(at: usize, place: &'a Cell<usize>, line: &'a [u8]) -> Self {
        let mut words = fields(line);
        let keyword = capitals(words.next().unwrap_or_default());
        let options = options(words).collect();
        Self { at, place, scope: Scope::Part, keyword, options, lines: Vec::new() }
    }

    /// Number of lines of data.
    pub(super) fn len(&self) -> usize {
        self.lines.len()
    }

    /// The lines of data, to which errors point meanwhile; then to the keyword again.
    pub(super) fn lines(&self) -> impl Iterator<Item = &'a [u8]> {
        let mut lines = self.lines.iter();
        std::iter::from_fn(move || {
            let next = lines.next();
            self.place.set(next.map_or(self.at, |line| line.0));
            next.map(|line| line.1)
        })
    }

    /// The value of an option; empty where it stands alone.
    pub(super) fn option(&self, key: &str) -> Option<&'a [u8]> {
        self.options.iter().find(|(known, _)| known == key).map(|&(_, value)| value)
    }

    /// The name that an option gives.
    pub(super) fn name(&self, key: &str) -> Option<Name> {
        self.option(key).filter(|value| !value.is_empty()).map(Name::new)
    }

    /// The name that an option must give.
    pub(super) fn required(&self, key: &str, expected: &'static str) -> Result<Name> {
        self.name(key).ok_or(Problem::Missing { expected })
    }

    /// Begins to read the block. Refuses options beside these, which might change what the lines mean.
    pub(super) fn allow(&self, known: &[&str]) -> Result<()> {
        self.place.set(self.at);
        match self.options.iter().find(|(key, _)| !known.contains(&key.as_str())) {
            None => Ok(()),
            Some((key, _)) => {
                let value = format!("{key} of *{}", self.keyword);
                let advice = "write the mesh without it";
                Err(Problem::unsupported("the option", value, advice))
            }
        }
    }
}

/// A real number, as Fortran may write it (`1.5D-3`) too; one that is left out is zero.
pub(super) fn real(word: &[u8]) -> Result<f64> {
    if word.is_empty() {
        return Ok(0.0);
    }
    let text = String::from_utf8_lossy(word).replace(['d', 'D'], "e");
    text.parse().map_err(|_| Problem::expected("a coordinate", word))
}
