//! Directories that appear whole or not at all, and arrays in files.

use std::fs::{self, File};
use std::io::{BufReader, BufWriter, Read, Write};
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

/// First bytes of a file of arrays.
const MAGIC: &[u8; 8] = b"SINEWGN1";

/// Writes a count, identities and single-precision arrays, little-endian.
pub(crate) fn write_arrays<'a>(
    path: &Path,
    count: u64,
    ids: &[u64],
    arrays: impl Iterator<Item = &'a [f32]>,
) -> Result<()> {
    let mut bytes = MAGIC.to_vec();
    let put = |value: u64, bytes: &mut Vec<u8>| bytes.extend(value.to_le_bytes());
    put(count, &mut bytes);
    put(ids.len() as u64, &mut bytes);
    ids.iter().for_each(|id| put(*id, &mut bytes));
    for array in arrays {
        put(array.len() as u64, &mut bytes);
        array.iter().for_each(|value| bytes.extend(value.to_le_bytes()));
    }
    fs::write(path, bytes).map_err(file_error(path))
}

/// Count, identities and arrays of a file written by [`write_arrays`].
pub(crate) fn read_arrays(path: &Path) -> Result<(u64, Vec<u64>, Vec<Vec<f32>>)> {
    let mut bytes = Vec::new();
    let mut file = File::open(path).map_err(file_error(path))?;
    file.read_to_end(&mut bytes).map_err(file_error(path))?;
    let truncated = || Error::Format {
        path: path.into(),
        reason: "not a file of arrays, or cut short; use another checkpoint".into(),
    };
    let rest = bytes.strip_prefix(MAGIC).ok_or_else(truncated)?;
    parse_arrays(rest).ok_or_else(truncated)
}

fn parse_arrays(mut rest: &[u8]) -> Option<(u64, Vec<u64>, Vec<Vec<f32>>)> {
    fn take<'a>(rest: &mut &'a [u8], bytes: usize) -> Option<&'a [u8]> {
        let (head, tail) = rest.split_at_checked(bytes)?;
        *rest = tail;
        Some(head)
    }
    fn number(rest: &mut &[u8]) -> Option<u64> {
        Some(u64::from_le_bytes(take(rest, 8)?.try_into().ok()?))
    }
    let count = number(&mut rest)?;
    let ids = usize::try_from(number(&mut rest)?).ok()?;
    let bytes = take(&mut rest, ids.checked_mul(8)?)?;
    let ids = bytes.as_chunks().0.iter().map(|id| u64::from_le_bytes(*id)).collect();
    let mut arrays = Vec::new();
    while !rest.is_empty() {
        let length = usize::try_from(number(&mut rest)?).ok()?;
        let bytes = take(&mut rest, length.checked_mul(4)?)?;
        arrays.push(bytes.as_chunks().0.iter().map(|value| f32::from_le_bytes(*value)).collect());
    }
    Some((count, ids, arrays))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn arrays_round_trip_and_a_cut_file_is_refused() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arrays");
        let arrays = [vec![1.0, -0.0, f32::MIN_POSITIVE], vec![]];
        write_arrays(&path, 7, &[3, 4], arrays.iter().map(Vec::as_slice)).unwrap();
        let read = read_arrays(&path).unwrap();
        assert_eq!(read, (7, vec![3, 4], arrays.to_vec()));
        let bytes = fs::read(&path).unwrap();
        for length in 0..bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            // Cutting off a whole trailing array leaves a valid file of fewer arrays.
            let fewer = read_arrays(&path).is_ok_and(|(_, _, arrays)| arrays.len() < 2);
            assert!(
                fewer || matches!(read_arrays(&path), Err(Error::Format { .. })),
                "length {length}"
            );
        }
    }

    #[test]
    fn a_failed_write_leaves_the_directory_as_it_was() {
        let folder = tempfile::tempdir().unwrap();
        let place = folder.path().join("checkpoint");
        let write = |text: &'static str| move |path: &Path| write_json(&path.join("a.json"), &text);
        replace_directory(&place, write("first")).unwrap();
        let failed = replace_directory(&place, |path| {
            write("second")(path)?;
            Err(Error::NothingToTrain("interrupted"))
        });
        assert!(failed.is_err());
        let read = || read_json::<String>(&open_directory(&place).join("a.json")).unwrap();
        assert_eq!(read(), "first");
        fs::rename(&place, sibling(&place, ".previous")).unwrap(); // a kill between the renames
        assert_eq!(read(), "first");
        replace_directory(&place, write("second")).unwrap();
        assert_eq!(read(), "second");
    }
}
