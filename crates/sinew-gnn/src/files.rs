//! Directories that appear whole or not at all, and JSON in them.

use std::fs;
use std::path::{Path, PathBuf};

use serde::Serialize;
use serde::de::DeserializeOwned;

use crate::error::{Error, Result};

fn file_error(path: &Path) -> impl FnOnce(std::io::Error) -> Error + '_ {
    move |source| Error::File { path: path.into(), source }
}

fn sibling(directory: &Path, suffix: &str) -> PathBuf {
    let mut name = directory.file_name().unwrap_or_default().to_os_string();
    name.push(suffix);
    directory.with_file_name(name)
}

/// Writes a directory beside its place and then renames it there. Whenever the process is killed,
/// either `directory` or its sibling `….previous` is whole, and [`open_directory`] finds it.
pub(crate) fn replace_directory(
    directory: &Path,
    write: impl FnOnce(&Path) -> Result<()>,
) -> Result<()> {
    let (fresh, previous) = (sibling(directory, ".new"), sibling(directory, ".previous"));
    let remove = |earlier: &Path| match earlier.exists() {
        true => fs::remove_dir_all(earlier).map_err(file_error(earlier)),
        false => Ok(()),
    };
    remove(&fresh)?;
    fs::create_dir_all(&fresh).map_err(file_error(&fresh))?;
    write(&fresh)?;
    if directory.exists() {
        remove(&previous)?;
        fs::rename(directory, &previous).map_err(file_error(directory))?;
    }
    fs::rename(&fresh, directory).map_err(file_error(&fresh))?;
    remove(&previous)
}

/// The directory, or its predecessor if a kill came between the two renames of [`replace_directory`].
pub(crate) fn open_directory(directory: &Path) -> PathBuf {
    let previous = sibling(directory, ".previous");
    if !directory.exists() && previous.exists() { previous } else { directory.into() }
}

pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let text = serde_json::to_vec(value).map_err(std::io::Error::from);
    text.and_then(|text| fs::write(path, text)).map_err(file_error(path))
}

pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let text = fs::read(path).map_err(file_error(path))?;
    serde_json::from_slice(&text)
        .map_err(|error| Error::Format { path: path.into(), reason: error.to_string() })
}
