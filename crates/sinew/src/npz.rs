//! Several arrays in one file that NumPy reads: a zip archive of npy files, stored as they are.

use std::io::{self, Write};
use std::path::Path;
use zip::{CompressionMethod, ZipWriter, write::SimpleFileOptions};

/// An array by name, with its shape and numbers row by row.
pub type Named<'a> = (&'a str, &'a [usize], &'a [f64]);

/// Writes arrays for `numpy.load`.
///
/// # Errors
/// A file that cannot be written.
///
/// # Panics
/// When a shape does not hold its numbers.
pub fn write(path: &Path, arrays: &[Named<'_>]) -> io::Result<()> {
    let mut archive = ZipWriter::new(io::BufWriter::new(std::fs::File::create(path)?));
    for (name, shape, values) in arrays {
        let content = sinew_mesh::to_npy(shape, values);
        let options = SimpleFileOptions::default()
            .compression_method(CompressionMethod::Stored)
            .large_file(u32::try_from(content.len()).is_err());
        archive.start_file(format!("{name}.npy"), options)?;
        archive.write_all(&content)?;
    }
    archive.finish()?.flush()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::io::Read;

    #[test]
    fn an_archive_holds_its_npy_files() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("arrays.npz");
        let values: Vec<f64> = (0..6).map(f64::from).collect();
        write(&path, &[("theta", &[2, 3], &values), ("energy", &[1], &[7.5])]).unwrap();
        let mut archive = zip::ZipArchive::new(std::fs::File::open(path).unwrap()).unwrap();
        for (name, content) in [
            ("theta.npy", sinew_mesh::to_npy(&[2, 3], &values)),
            ("energy.npy", sinew_mesh::to_npy(&[1], &[7.5])),
        ] {
            let mut found = Vec::new();
            archive.by_name(name).unwrap().read_to_end(&mut found).unwrap();
            assert_eq!(found, content);
        }
        assert_eq!(archive.len(), 2);
    }
}
