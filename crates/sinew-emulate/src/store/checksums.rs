//! Checksums of stored files. A damaged, lost or foreign file is refused.

use crate::store::{read_json, write_json};
use crate::{Error, Result};
use std::collections::BTreeMap;
use std::path::Path;

/// CRC-32 of files, by their names within a folder.
pub(crate) type Checksums = BTreeMap<String, u32>;

/// Holds the checksums of a folder; written last, so that a folder with it is whole.
pub(crate) const SEAL: &str = "checksums.json";

/// Checksums of files of a folder.
///
/// # Errors
/// A file that cannot be read.
pub(crate) fn of(folder: &Path, names: impl IntoIterator<Item = String>) -> Result<Checksums> {
    let sum = |name: String| {
        let path = folder.join(&name);
        let bytes = std::fs::read(&path).map_err(|source| Error::File { path, source })?;
        Ok((name, crc32fast::hash(&bytes)))
    };
    names.into_iter().map(sum).collect()
}

/// Names of the files in a folder within `folder`; none where there is no such folder.
fn files(folder: &Path, part: &str) -> Result<Vec<String>> {
    let path = folder.join(part);
    if !path.is_dir() {
        return Ok(Vec::new());
    }
    let failed = |source| Error::File { path: path.clone(), source };
    let mut names = Vec::new();
    for entry in std::fs::read_dir(&path).map_err(failed)? {
        let entry = entry.map_err(failed)?;
        if entry.path().is_file() {
            names.push(format!("{part}/{}", entry.file_name().to_string_lossy()));
        }
    }
    names.sort();
    Ok(names)
}

/// Seals a folder: one file of it, and all files of a folder within it.
///
/// # Errors
/// A file that cannot be read or written.
pub(crate) fn seal(folder: &Path, file: &str, part: &str) -> Result<()> {
    let names = std::iter::once(file.to_string()).chain(files(folder, part)?);
    write_json(&folder.join(SEAL), &of(folder, names)?)
}

/// Checksums of a sealed folder whose files are unchanged.
///
/// # Errors
/// No seal, or a file that is not as it was sealed.
pub(crate) fn check(folder: &Path) -> Result<Checksums> {
    let Some(sealed) = read_json::<Checksums>(&folder.join(SEAL))? else {
        return damaged(
            folder,
            SEAL,
            "is missing: files were lost, or an earlier version wrote them",
        );
    };
    for (name, sum) in &sealed {
        match of(folder, [name.clone()]) {
            Ok(found) if found[name] == *sum => {}
            Ok(_) => return damaged(folder, name, "is not as it was stored"),
            Err(_) if !folder.join(name).exists() => return damaged(folder, name, "is missing"),
            Err(unreadable) => return Err(unreadable),
        }
    }
    Ok(sealed)
}

/// Requires that a file and all files of a folder within are among what was sealed.
///
/// # Errors
/// A file that was added or renamed since.
pub(crate) fn require(sealed: &Checksums, folder: &Path, file: &str, part: &str) -> Result<()> {
    let mut names = std::iter::once(file.to_string()).chain(files(folder, part)?);
    match names.find(|name| !sealed.contains_key(name)) {
        None => Ok(()),
        Some(name) => damaged(folder, &name, "was not stored with the other files"),
    }
}

fn damaged<T>(folder: &Path, name: &str, how: &'static str) -> Result<T> {
    Err(Error::Refused(format!(
        "{} {how}; take the whole folder from a copy, or make it again",
        folder.join(name).display()
    )))
}
