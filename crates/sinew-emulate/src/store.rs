//! Files that appear whole or not at all, and checksums that refuse damaged, lost or foreign ones.

pub(crate) mod identity;
pub(crate) mod record;

use crate::error::at;
use crate::{Error, Result};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

/// Writes `value` as JSON at once: a reader sees the old file or the new one, never a part.
///
/// # Errors
/// A folder or file that cannot be written, by path.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let bytes = serde_json::to_vec_pretty(value).map_err(|e| content(path, &e))?;
    write_bytes(path, &bytes)
}

/// Reads what [`write_json`] wrote; `None` if there is no such file.
///
/// # Errors
/// A file that cannot be read or holds something else, by path.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    if !path.exists() {
        return Ok(None);
    }
    let text = fs::read(path).map_err(at(path))?;
    serde_json::from_slice(&text).map(Some).map_err(|e| content(path, &e))
}

/// Writes rows of equal length as a npy table.
///
/// # Errors
/// A folder or file that cannot be written, by path.
pub fn write_table(path: &Path, rows: &[Vec<f64>]) -> Result<()> {
    let columns = rows.first().map_or(0, Vec::len);
    write_bytes(path, &sinew_mesh::to_npy(&[rows.len(), columns], &rows.concat()))
}

/// Reads what [`write_table`] wrote.
///
/// # Errors
/// A file that cannot be read or is no table, by path.
pub fn read_table(path: &Path) -> Result<Vec<Vec<f64>>> {
    parse_table(path, &fs::read(path).map_err(at(path))?)
}

/// Rows along the first axis of an npy array that was read from `path`.
///
/// # Errors
/// Bytes that are no npy array of floating-point numbers, by path.
pub fn parse_table(path: &Path, bytes: &[u8]) -> Result<Vec<Vec<f64>>> {
    let array = sinew_mesh::parse_npy(&path.display().to_string(), bytes);
    let array = array.map_err(|error| content(path, &error))?;
    match (array.shape.as_slice(), array.values) {
        ([0, ..], _) => Ok(Vec::new()),
        (&[rows, ..], sinew_mesh::FieldValues::Float(values)) => {
            Ok(values.chunks((values.len() / rows).max(1)).map(<[f64]>::to_vec).collect())
        }
        _ => Err(content(path, &"it holds no table of numbers")),
    }
}

/// An error about what a file holds.
pub(crate) fn content(path: &Path, reason: &dyn std::fmt::Display) -> Error {
    Error::Refused(format!(
        "{} is damaged or of another version ({reason}); delete it, or begin the run again (--restart)",
        path.display()
    ))
}

/// Writes bytes at once, as [`write_json`] does.
///
/// # Errors
/// A folder or file that cannot be written, by path.
pub fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    // One temporary name per writer: shards on several machines may have the same process number.
    let now = std::time::SystemTime::now().duration_since(std::time::UNIX_EPOCH);
    let moment = now.map_or(0, |now| now.as_nanos());
    let partial = path.with_extension(format!("{}-{moment}.partial", std::process::id()));
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&partial, bytes))
        .and_then(|()| fs::rename(&partial, path))
        .map_err(at(path))
}

/// CRC-32 of files, by their names within a folder.
pub(crate) type Checksums = BTreeMap<String, u32>;

/// Holds the checksums of a folder; written last, so that a folder with it is whole.
pub(crate) const SEAL: &str = "checksums.json";

/// Checksums of files of a folder.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn checksums(
    folder: &Path,
    names: impl IntoIterator<Item = String>,
) -> Result<Checksums> {
    let sum = |name: String| {
        let path = folder.join(&name);
        let bytes = fs::read(&path).map_err(at(&path))?;
        Ok((name, crc32fast::hash(&bytes)))
    };
    names.into_iter().map(sum).collect()
}

/// Names of a file, and of the files in a folder within `folder`, if there is one.
///
/// # Errors
/// A folder that cannot be read.
pub(crate) fn files(folder: &Path, file: &str, part: &str) -> Result<Vec<String>> {
    let (path, mut names) = (folder.join(part), vec![file.to_string()]);
    if !path.is_dir() {
        return Ok(names);
    }
    for entry in fs::read_dir(&path).map_err(at(&path))? {
        let entry = entry.map_err(at(&path))?;
        if entry.path().is_file() {
            names.push(format!("{part}/{}", entry.file_name().to_string_lossy()));
        }
    }
    names[1..].sort();
    Ok(names)
}

/// Seals a folder by files within it.
///
/// # Errors
/// A file that cannot be read or written.
pub(crate) fn seal(folder: &Path, names: impl IntoIterator<Item = String>) -> Result<()> {
    write_json(&folder.join(SEAL), &checksums(folder, names)?)
}

/// Checksums of a sealed folder whose files are unchanged.
///
/// # Errors
/// No seal, or a file that is not as it was sealed.
pub(crate) fn check_seal(folder: &Path) -> Result<Checksums> {
    let missing = "is missing: files were lost, or an earlier version wrote them";
    let sealed = read_json::<Checksums>(&folder.join(SEAL))?;
    let sealed = sealed.map_or_else(|| damaged(folder, SEAL, missing), Ok)?;
    for (name, sum) in &sealed {
        match checksums(folder, [name.clone()]) {
            Ok(found) if found[name] == *sum => {}
            Ok(_) => return damaged(folder, name, "is not as it was stored"),
            Err(_) if !folder.join(name).exists() => return damaged(folder, name, "is missing"),
            Err(unreadable) => return Err(unreadable),
        }
    }
    Ok(sealed)
}

/// Requires that files are among what was sealed.
///
/// # Errors
/// A file that was added or renamed since.
pub(crate) fn require_sealed(sealed: &Checksums, folder: &Path, names: &[String]) -> Result<()> {
    let added = names.iter().find(|name| !sealed.contains_key(*name));
    added.map_or(Ok(()), |name| damaged(folder, name, "was not stored with the other files"))
}

fn damaged<T>(folder: &Path, name: &str, how: &'static str) -> Result<T> {
    Err(Error::Refused(format!(
        "{} {how}; take the whole folder from a copy, or make it again",
        folder.join(name).display()
    )))
}
