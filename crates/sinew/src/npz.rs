//! Several arrays in one file that NumPy reads: a zip archive of npy files, stored as they are.

use sinew_mesh::to_npy;
use std::borrow::Cow;
use std::io::{self, Write};
use std::path::Path;
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

/// An array by name, with its shape and numbers row by row.
pub type Named<'a> = (&'a str, &'a [usize], &'a [f64]);

/// Writes arrays for `numpy.load`, and further ones by name and content of their npy files.
///
/// # Errors
/// A file that cannot be written.
///
/// # Panics
/// When a shape does not hold its numbers.
pub fn write(path: &Path, arrays: &[Named<'_>], further: &[(&str, Vec<u8>)]) -> io::Result<()> {
    let mut archive = ZipWriter::new(io::BufWriter::new(std::fs::File::create(path)?));
    let own = arrays.iter().map(|(name, shape, values)| (name, Cow::Owned(to_npy(shape, values))));
    let further = further.iter().map(|(name, content)| (name, Cow::Borrowed(&content[..])));
    for (name, content) in own.chain(further) {
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(u32::try_from(content.len()).is_err());
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(&content)?;
    }
    archive.finish()?.flush()
}
