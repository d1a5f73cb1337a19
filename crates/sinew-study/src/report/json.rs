//! `report.json`: numbers for programs, laid out for people.

use std::fs;
use std::io::{self, Write};
use std::path::Path;

use serde::{Deserialize, Serialize};
use serde_json::ser::{Formatter, PrettyFormatter, Serializer};

use super::{Report, ReportError};

/// Version of `report.json` and `samples.csv`, raised with any change of their fields.
pub const SCHEMA: u32 = 1;

/// The text of `report.json`: objects indented, lists of numbers on one line.
///
/// # Errors
/// [`ReportError::Json`] if a number outside of the method rows is not finite in a way
/// JSON cannot hold.
pub fn to_json(report: &Report) -> Result<String, ReportError> {
    pretty(report)
}

/// Any value as JSON, objects indented, lists of numbers on one line.
///
/// # Errors
/// As [`to_json`].
pub(crate) fn pretty(value: &impl Serialize) -> Result<String, ReportError> {
    let mut bytes = Vec::new();
    let mut serializer = Serializer::with_formatter(&mut bytes, InlineArrays::default());
    value.serialize(&mut serializer)?;
    bytes.push(b'\n');
    // serde_json writes UTF-8 only, so nothing is replaced here.
    Ok(String::from_utf8_lossy(&bytes).into_owned())
}

/// Reads `report.json`.
///
/// # Errors
/// [`ReportError::Schema`] for another version, [`ReportError::Json`] for anything that
/// is no report (including rows with numbers a [`super::MethodRow`] refuses),
/// [`ReportError::Io`] if the file cannot be read.
pub fn read_json(path: &Path) -> Result<Report, ReportError> {
    let text = fs::read_to_string(path).map_err(|source| ReportError::io(path, source))?;
    parse(&text)
}

/// The schema number first, so that another version is named as such and not as a
/// missing field.
pub(super) fn parse(text: &str) -> Result<Report, ReportError> {
    #[derive(Deserialize)]
    struct Version {
        schema: u64,
    }
    let found = serde_json::from_str::<Version>(text)?.schema;
    if found != u64::from(SCHEMA) {
        let expected = SCHEMA;
        return Err(ReportError::Schema { found, expected });
    }
    Ok(serde_json::from_str(text)?)
}

/// Pretty objects, compact arrays.
#[derive(Default)]
struct InlineArrays {
    pretty: PrettyFormatter<'static>,
}

impl Formatter for InlineArrays {
    fn begin_array_value<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        if first { Ok(()) } else { writer.write_all(b", ") }
    }

    fn begin_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.begin_object(writer)
    }

    fn end_object<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.end_object(writer)
    }

    fn begin_object_key<W: ?Sized + Write>(
        &mut self,
        writer: &mut W,
        first: bool,
    ) -> io::Result<()> {
        self.pretty.begin_object_key(writer, first)
    }

    fn begin_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.begin_object_value(writer)
    }

    fn end_object_value<W: ?Sized + Write>(&mut self, writer: &mut W) -> io::Result<()> {
        self.pretty.end_object_value(writer)
    }
}
