//! Intermediate results on disk, so that an interrupted run goes on where it stopped.

use anyhow::{Context, Result, bail, ensure};
use serde::Serialize;
use serde::de::DeserializeOwned;
use std::fs;
use std::path::Path;

/// Writes `value` as JSON at once: a reader sees the old file or the new one, never a part.
///
/// # Errors
/// A folder or file that cannot be written, by path.
pub fn write_json(path: &Path, value: &impl Serialize) -> Result<()> {
    write_bytes(path, &serde_json::to_vec_pretty(value)?)
}

/// Writes `text` at once, as [`write_json`] does.
///
/// # Errors
/// A folder or file that cannot be written, by path.
pub fn write_text(path: &Path, text: &str) -> Result<()> {
    write_bytes(path, text.as_bytes())
}

/// Reads what [`write_json`] wrote; `None` if there is no such file.
///
/// # Errors
/// A file that cannot be read or holds something else, by path.
pub fn read_json<T: DeserializeOwned>(path: &Path) -> Result<Option<T>> {
    if !path.exists() {
        return Ok(None);
    }
    let text = fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
    let advice = "delete it, or start without --resume";
    let value = serde_json::from_slice(&text)
        .with_context(|| format!("{} is not a file of this version; {advice}", path.display()))?;
    Ok(Some(value))
}

/// Writes rows of equal length as a npy table.
///
/// # Errors
/// A folder or file that cannot be written, by path.
pub fn write_table(path: &Path, rows: &[Vec<f64>]) -> Result<()> {
    let columns = rows.first().map_or(0, Vec::len);
    write_bytes(path, &sinew_mesh::to_npy(&[rows.len(), columns], &rows.concat()))
}

/// Reads a npy array as rows along its first axis.
///
/// # Errors
/// Bytes that are no npy array, by name.
pub fn parse_table(name: &str, bytes: &[u8]) -> Result<Vec<Vec<f64>>> {
    let array = sinew_mesh::parse_npy(name, bytes)?;
    let Some(&rows) = array.shape.first() else {
        bail!("{name} holds a single number, not a table")
    };
    ensure!(rows > 0, "{name} holds no rows");
    let sinew_mesh::FieldValues::Float(values) = array.values else {
        bail!("{name} holds integers")
    };
    Ok(values.chunks((values.len() / rows).max(1)).map(<[f64]>::to_vec).collect())
}

/// Reads what [`write_table`] wrote.
///
/// # Errors
/// A file that cannot be read or is no table, by path.
pub fn read_table(path: &Path) -> Result<Vec<Vec<f64>>> {
    let bytes = fs::read(path).with_context(|| format!("{} cannot be read", path.display()))?;
    parse_table(&path.display().to_string(), &bytes)
}

fn write_bytes(path: &Path, bytes: &[u8]) -> Result<()> {
    let folder = path.parent().unwrap_or(Path::new("."));
    let partial = path.with_extension("partial");
    fs::create_dir_all(folder)
        .and_then(|()| fs::write(&partial, bytes))
        .and_then(|()| fs::rename(&partial, path))
        .with_context(|| format!("{} cannot be written", path.display()))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_back() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("deep/numbers.json");
        assert_eq!(read_json::<Vec<f64>>(&path).unwrap(), None);
        write_json(&path, &vec![0.1, f64::MIN_POSITIVE]).unwrap();
        assert_eq!(read_json(&path).unwrap(), Some(vec![0.1, f64::MIN_POSITIVE]));
        let rows = vec![vec![1.0, 2.0 / 3.0, -0.0], vec![3e300, 4.0, 5.0]];
        let path = folder.path().join("table.npy");
        write_table(&path, &rows).unwrap();
        assert_eq!(read_table(&path).unwrap(), rows);
    }

    #[test]
    fn a_damaged_file_says_what_to_do() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("numbers.json");
        fs::write(&path, "[1, 2").unwrap();
        let message = format!("{:#}", read_json::<Vec<f64>>(&path).unwrap_err());
        assert!(message.contains("numbers.json") && message.contains("--resume"), "{message}");
    }
}
