//! The text of a case file: lines of its keys, errors there, and suggestions for misspelt ones.

use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer};
use toml::de::{DeTable, DeValue};

/// Name and text of a case file.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Source {
    pub(crate) file: String,
    pub(crate) text: String,
    /// Whether the text was written here, so that its lines say nothing to its user.
    unseen: bool,
}

impl Source {
    pub(crate) fn new(file: &str, text: &str) -> Self {
        Self { file: file.into(), text: text.into(), unseen: false }
    }

    /// Text of keys in memory, of which no error names a line.
    pub(crate) fn unseen(name: &str, text: &str) -> Self {
        Self { unseen: true, ..Self::new(name, text) }
    }

    /// An error at a key, given with those of the tables around it; entries of arrays by their index.
    pub(crate) fn error(&self, keys: &[&str], reason: String) -> CaseError {
        let (file, line, key) = (self.file.clone(), self.line_of(keys), keys.join("."));
        CaseError { file, line, key, reason }
    }

    /// Refuses what is wrong at a key.
    pub(crate) fn refuse_if<R: Into<String>>(
        &self,
        wrong: bool,
        keys: &[&str],
        reason: impl FnOnce() -> R,
    ) -> Result<()> {
        if wrong { Err(self.error(keys, reason().into())) } else { Ok(()) }
    }

    /// An error of the TOML reader, with what was meant.
    pub(crate) fn syntax(&self, error: &toml::de::Error) -> CaseError {
        let span = error.span();
        let start = span.as_ref().map(|span| span.start);
        let (keys, reason) = match (DeTable::parse(&self.text), error.message().trim_end()) {
            (Ok(root), message) => {
                let keys = start.and_then(|start| keys_at(root.get_ref(), start));
                (keys.unwrap_or_default(), explain(message))
            }
            (Err(_), "duplicate key") => {
                let key = span.and_then(|span| self.text.get(span)).unwrap_or_default().trim();
                (Vec::new(), format!("`{key}` is there twice; keep one"))
            }
            (Err(_), message) => {
                let advice = "write KEY = VALUE, with texts in quotes, lists in brackets, points in decimals and / for \\ in paths";
                (Vec::new(), format!("this is not TOML ({message}); {advice}"))
            }
        };
        // A key missing at the top level has no line.
        let whole = keys.is_empty() && reason.contains(IS_MISSING);
        let line = start.filter(|_| !whole && !self.unseen).map(|start| self.line_at(start));
        CaseError { file: self.file.clone(), line, key: keys.join("."), reason }
    }

    fn line_at(&self, byte: usize) -> usize {
        1 + self.text.bytes().take(byte).filter(|&byte| byte == b'\n').count()
    }

    /// Line of the last of the keys that there is, where its user sees it.
    pub(crate) fn line_of(&self, keys: &[&str]) -> Option<usize> {
        let text = (!self.unseen).then_some(&self.text)?;
        let root = DeTable::parse(text).ok()?.into_inner();
        let (first, rest) = keys.split_first()?;
        let (key, mut value) = root.iter().find(|(key, _)| key.get_ref() == first)?;
        let mut start = key.span().start;
        for name in rest {
            let inner = value.get_ref();
            let next = match (inner, name.parse::<usize>()) {
                (DeValue::Array(array), Ok(index)) => {
                    array.get(index).map(|entry| (entry.span().start, entry))
                }
                (DeValue::Table(table), _) => {
                    let found = table.iter().find(|(key, _)| key.get_ref() == name);
                    found.map(|(key, value)| (key.span().start, value))
                }
                _ => None,
            };
            let Some((at, entry)) = next else { break };
            (start, value) = (at, entry);
        }
        Some(self.line_at(start))
    }
}

/// Reads the tables of a TOML file that is no case; `file` names it in errors.
///
/// # Errors
/// As [`Case::parse`](super::Case::parse).
pub fn parse_tables<T: DeserializeOwned>(text: &str, file: &str) -> Result<T, CaseError> {
    toml::from_str(text).map_err(|error| Source::new(file, text).syntax(&error))
}

/// The innermost key whose name or value is at a byte, with those of the tables around it.
fn keys_at(table: &DeTable<'_>, byte: usize) -> Option<Vec<String>> {
    let inner = |name: String, value: &DeValue<'_>, own: bool| {
        let within = match value {
            DeValue::Table(table) => keys_at(table, byte),
            DeValue::Array(array) => (0..).zip(array.iter()).find_map(|(index, entry)| {
                let own = entry.span().contains(&byte).then(|| vec![index.to_string()]);
                let DeValue::Table(table) = entry.get_ref() else { return own };
                let within = keys_at(table, byte);
                within.map(|keys| [vec![index.to_string()], keys].concat()).or(own)
            }),
            _ => None,
        };
        match within {
            Some(keys) => Some([vec![name], keys].concat()),
            None => own.then(|| vec![name]),
        }
    };
    table.iter().find_map(|(key, value)| {
        let own = key.span().contains(&byte) || value.span().contains(&byte);
        inner(key.get_ref().to_string(), value.get_ref(), own)
    })
}

const IS_MISSING: &str = " is missing";

/// Message of the TOML reader, in words, with the key or name that was meant.
fn explain(message: &str) -> String {
    let message = message.trim_end();
    let mut quoted = message.split('`').skip(1).step_by(2);
    let what = [("unknown field", "there is no key"), ("unknown variant", "there is no choice")];
    if let Some((_, say)) = what.iter().find(|(start, _)| message.starts_with(start))
        && let Some(word) = quoted.next()
    {
        return format!("{say} `{word}` here{}", advise(word, quoted, "it knows"));
    }
    if let Some(key) = message.strip_prefix("missing field ") {
        return format!(
            "{key}{IS_MISSING}; add it (sinew new OnceClampedBeam prints a whole case, docs/case-file.md explains every key)"
        );
    }
    let wrong =
        ["invalid type: ", "invalid value: "].iter().find_map(|start| message.strip_prefix(start));
    match wrong.and_then(|wrong| wrong.split_once(", expected ")) {
        Some((found, expected)) => {
            format!("{} stands here; give {}", kind(found), wanted(expected))
        }
        None => message.to_string(),
    }
}

/// A value that the reader found, in words.
fn kind(found: &str) -> String {
    let number = found.strip_prefix("integer ").or_else(|| found.strip_prefix("floating point "));
    match (number, found.strip_prefix("string ")) {
        (Some(number), _) => format!("the number {}", number.trim_matches('`')),
        (_, Some(text)) => format!("the text {text}"),
        _ if found == "sequence" => "a list".into(),
        _ if found == "map" => "a table".into(),
        _ => found.replace("boolean ", ""),
    }
}

/// Expectation of the TOML reader, in words.
fn wanted(expected: &str) -> String {
    match expected {
        "f64" | "f32" => "a number".into(),
        "usize" | "u64" | "u32" => "a whole number, 0 or more".into(),
        "a string" | "path string" => "a text in quotes".into(),
        "a sequence" => "a list in brackets".into(),
        "a map" => "a table".into(),
        "a boolean" => "true or false".into(),
        named if named.starts_with("struct ") => "a table of keys".into(),
        other => other.into(),
    }
}

/// The known word that a misspelt one stands for. A number stands for itself.
pub(crate) fn meant<'a>(word: &str, known: &[&'a str]) -> Option<&'a str> {
    let length = word.chars().count();
    let distance = |name: &&&str| strsim::osa_distance(&word.to_lowercase(), &name.to_lowercase());
    let nearest = known.iter().min_by_key(distance).filter(|_| word.parse::<f64>().is_err());
    // A quarter of the letters may be wrong, but not all of a short word.
    nearest.filter(|name| distance(name) < length.min(2 + length / 4)).copied()
}

/// Suggestion for a misspelt word, or all known ones.
pub(crate) fn advise<'a>(
    word: &str,
    known: impl IntoIterator<Item = &'a str>,
    what: &str,
) -> String {
    let known: Vec<&str> = known.into_iter().collect();
    match meant(word, &known) {
        Some(name) => format!("; did you mean `{name}`?"),
        None if known.is_empty() => format!("; {what}: none"),
        None => format!("; {what}: {}", known.join(", ")),
    }
}

/// Name of cells: a set, a label such as `region:3`, or the number of a label.
pub(crate) fn cell_name(value: &toml::Value) -> String {
    value.as_str().map_or_else(|| value.to_string(), String::from)
}

/// A list of so many values and not more, which the TOML reader overlooks in arrays.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Exactly<T, const N: usize>(pub [T; N]);

impl<'de, T: Deserialize<'de>, const N: usize> Deserialize<'de> for Exactly<T, N> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let all = Vec::deserialize(deserializer)?;
        all.try_into().map(Self).map_err(|all: Vec<T>| {
            let (found, values) = (all.len(), if all.len() == 1 { "value" } else { "values" });
            D::Error::custom(format!("{found} {values} where {N} belong; give {N}"))
        })
    }
}

/// Result of reading a case file.
pub(crate) type Result<T, E = CaseError> = std::result::Result<T, E>;

/// Why a case file describes no body: something wrong at a key, or in the file.
#[derive(Debug, thiserror::Error)]
#[error("{file}{}{}: {reason}", place(*line), named(key))]
#[non_exhaustive]
pub struct CaseError {
    /// The case file.
    pub file: String,
    /// Line, from 1.
    pub line: Option<usize>,
    /// The key with those of the tables around it, such as `parameters.mu`; empty for the whole file.
    pub key: String,
    /// Fault and advice.
    pub reason: String,
}

fn place(line: Option<usize>) -> String {
    line.map_or(String::new(), |line| format!(", line {line}"))
}

fn named(key: &str) -> String {
    if key.is_empty() { String::new() } else { format!(", {key}") }
}
