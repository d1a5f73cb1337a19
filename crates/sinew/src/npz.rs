//! Several arrays in one file that NumPy reads: a zip archive of npy files, stored as they are.

use std::io::{self, Write};
use std::path::Path;

/// An array by name, with its shape and numbers row by row.
pub type Named<'a> = (&'a str, &'a [usize], &'a [f64]);

/// Writes arrays for `numpy.load`.
///
/// # Errors
/// A file that cannot be written, and archives of 4 GiB or more.
///
/// # Panics
/// When a shape does not hold its numbers.
pub fn write(path: &Path, arrays: &[Named<'_>]) -> io::Result<()> {
    let mut file = io::BufWriter::new(std::fs::File::create(path)?);
    file.write_all(&archive(arrays)?)?;
    file.flush()
}

fn archive(arrays: &[Named<'_>]) -> io::Result<Vec<u8>> {
    let (mut bytes, mut directory) = (Vec::new(), Vec::new());
    for (name, shape, values) in arrays {
        let content = sinew_mesh::to_npy(shape, values);
        let (name, offset) = (format!("{name}.npy"), fitting(bytes.len())?);
        let mut sum = flate2::Crc::new();
        sum.update(&content);
        // Fields 4 to 13 of a local header: version, flags, method, time, date, CRC-32, sizes, lengths of name and extra.
        let mut entry = Vec::new();
        for word in [20u16, 0, 0, 0, 0x21] {
            entry.extend(word.to_le_bytes());
        }
        for word in [sum.sum(), fitting(content.len())?, fitting(content.len())?] {
            entry.extend(word.to_le_bytes());
        }
        for word in [name.len() as u16, 0] {
            entry.extend(word.to_le_bytes());
        }
        bytes.extend(0x0403_4b50u32.to_le_bytes());
        bytes.extend(&entry);
        bytes.extend(name.as_bytes());
        bytes.extend(&content);
        // The directory repeats it with: made by, comment, disk, attributes (10 bytes of zeros), where it begins.
        directory.extend(0x0201_4b50u32.to_le_bytes());
        directory.extend(20u16.to_le_bytes());
        directory.extend(&entry);
        directory.extend([0; 10]);
        directory.extend(offset.to_le_bytes());
        directory.extend(name.as_bytes());
    }
    let (count, start) = (arrays.len() as u16, fitting(bytes.len())?);
    bytes.extend(&directory);
    bytes.extend(0x0605_4b50u32.to_le_bytes());
    bytes.extend([0; 4]);
    bytes.extend(count.to_le_bytes());
    bytes.extend(count.to_le_bytes());
    bytes.extend(fitting(directory.len())?.to_le_bytes());
    bytes.extend(start.to_le_bytes());
    bytes.extend([0; 2]);
    Ok(bytes)
}

fn fitting(length: usize) -> io::Result<u32> {
    u32::try_from(length)
        .map_err(|_| io::Error::other("the archive would exceed 4 GiB; write fewer cases"))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_archive_holds_its_npy_files_where_its_directory_says() {
        let values: Vec<f64> = (0..6).map(f64::from).collect();
        let bytes = archive(&[("theta", &[2, 3], &values), ("energy", &[1], &[7.5])]).unwrap();
        let at = |from: usize| u32::from_le_bytes(bytes[from..from + 4].try_into().unwrap());
        let end = bytes.len() - 22;
        assert_eq!(at(end), 0x0605_4b50);
        let mut entry = at(end + 16) as usize;
        for (name, content) in [
            ("theta.npy", sinew_mesh::to_npy(&[2, 3], &values)),
            ("energy.npy", sinew_mesh::to_npy(&[1], &[7.5])),
        ] {
            assert_eq!((at(entry), at(entry + 24) as usize), (0x0201_4b50, content.len()));
            let (header, data) =
                (at(entry + 42) as usize, at(entry + 42) as usize + 30 + name.len());
            assert_eq!(at(header), 0x0403_4b50);
            assert_eq!(&bytes[header + 30..data], name.as_bytes());
            assert_eq!(&bytes[data..data + content.len()], content);
            entry += 46 + name.len();
        }
        assert_eq!(entry, end);
    }
}
