//! Several arrays in one file that NumPy reads: a zip archive of npy files, stored as they are.

use sinew_mesh::{Field, parse_npy};
use std::fs::File;
use std::io::{self, Read, Write};
use std::path::Path;
use zip::{CompressionMethod, ZipArchive, ZipWriter, write::SimpleFileOptions};

/// Writes arrays for `numpy.load`, by name and content of their npy files ([`sinew_mesh::to_npy`]), made one after the other.
///
/// # Errors
/// A file that cannot be written.
pub fn write(path: &Path, arrays: impl IntoIterator<Item = (String, Vec<u8>)>) -> io::Result<()> {
    let mut archive = ZipWriter::new(io::BufWriter::new(File::create(path)?));
    for (name, content) in arrays {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(u32::try_from(content.len()).is_err());
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(&content)?;
    }
    archive.finish()?.flush()
}

/// Reads the shape and the numbers, row by row, of an array of a file that `numpy.savez` or `numpy.savez_compressed` wrote.
///
/// # Errors
/// A file that cannot be read, an array that is missing or not of numbers.
pub fn read(path: &Path, name: &str) -> io::Result<(Vec<usize>, Vec<f64>)> {
    let bytes = content(path, name)?.map_err(|held| {
        io::Error::other(format!("there is no array `{name}`; it holds: {}", held.join(", ")))
    })?;
    let array = parse_npy(name, &bytes).map_err(io::Error::other)?;
    Ok((array.shape, Field { components: 1, values: array.values }.to_f64().into_owned()))
}

/// Reads an array of texts, if the file has one of this name.
pub(crate) fn texts(path: &Path, name: &str) -> io::Result<Option<Vec<String>>> {
    let Ok(bytes) = content(path, name)? else { return Ok(None) };
    let start = bytes.iter().position(|&byte| byte == b'\n').map_or(bytes.len(), |end| end + 1);
    let (header, content) = bytes.split_at(start);
    let header = String::from_utf8_lossy(header);
    let length =
        header.split_once("'<U").and_then(|(_, rest)| rest.split('\'').next()?.parse().ok());
    let Some(length @ 1..) = length else { return Ok(None) };
    let letter = |bytes: &[u8; 4]| char::from_u32(u32::from_le_bytes(*bytes)).unwrap_or('?');
    let text =
        |text: &[[u8; 4]]| text.iter().map(letter).filter(|&letter| letter != '\0').collect();
    Ok(Some(content.as_chunks().0.chunks(length).map(text).collect()))
}

/// Bytes of an array, or the names of those that the file holds.
fn content(path: &Path, name: &str) -> io::Result<Result<Vec<u8>, Vec<String>>> {
    let mut archive = ZipArchive::new(io::BufReader::new(File::open(path)?))?;
    let held = archive.file_names().flatten();
    let held: Vec<_> = held.map(|file| file.trim_end_matches(".npy").to_string()).collect();
    if !held.iter().any(|held| held == name) {
        return Ok(Err(held));
    }
    let mut bytes = Vec::new();
    let file = archive.by_name(&format!("{name}.npy")).map_err(io::Error::from);
    file.and_then(|mut file| file.read_to_end(&mut bytes))
        .map_err(|error| io::Error::other(format!("{name}: {error}")))?;
    Ok(Ok(bytes))
}
