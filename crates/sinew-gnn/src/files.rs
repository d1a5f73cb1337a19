//! Directories that appear whole or not at all, and JSON in them.

use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Write};
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
    if fresh.exists() {
        fs::remove_dir_all(&fresh).map_err(file_error(&fresh))?;
    }
    fs::create_dir_all(&fresh).map_err(file_error(&fresh))?;
    write(&fresh)?;
    if directory.exists() {
        if previous.exists() {
            fs::remove_dir_all(&previous).map_err(file_error(&previous))?;
        }
        fs::rename(directory, &previous).map_err(file_error(directory))?;
    }
    fs::rename(&fresh, directory).map_err(file_error(&fresh))?;
    if previous.exists() {
        fs::remove_dir_all(&previous).map_err(file_error(&previous))?;
    }
    Ok(())
}

/// The directory, or its predecessor if a kill came between the two renames of [`replace_directory`].
pub(crate) fn open_directory(directory: &Path) -> PathBuf {
    let previous = sibling(directory, ".previous");
    if !directory.exists() && previous.exists() { previous } else { directory.into() }
}

pub(crate) fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    let file = File::create(path).map_err(file_error(path))?;
    let mut writer = BufWriter::new(file);
    let wrote = serde_json::to_writer(&mut writer, value).map_err(std::io::Error::from);
    wrote.and_then(|()| writer.flush()).map_err(file_error(path))
}

pub(crate) fn read_json<T: DeserializeOwned>(path: &Path) -> Result<T> {
    let file = File::open(path).map_err(file_error(path))?;
    serde_json::from_reader(BufReader::new(file))
        .map_err(|error| Error::Format { path: path.into(), reason: error.to_string() })
}
