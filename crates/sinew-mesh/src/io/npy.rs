//! NumPy's npy arrays (NEP 1, "A Simple File Format for NumPy Arrays").

use super::cursor::{Cursor, Encoding, Result, excerpt};
use super::number::NumberType;
use crate::{FieldValues, MeshError, Refusal};

const MAGIC: &[u8] = b"\x93NUMPY";
/// Arrays with more dimensions than this are taken for damaged (NumPy's own limit).
const MOST_DIMENSIONS: usize = 64;

/// An array of numbers, the last index fastest.
#[derive(Clone, Debug, PartialEq)]
pub struct NpyArray {
    /// Length of each dimension.
    pub shape: Vec<usize>,
    /// All numbers, as many as the product of the lengths.
    pub values: FieldValues,
}

/// Reads an npy file's bytes; `file` is its name for errors. Floats, integers and booleans of
/// either byte order are read; an array in Fortran order is transposed to C order.
///
/// # Errors
/// [`MeshError::Content`] with the place and the reason.
///
/// ```
/// let bytes = sinew_mesh::to_npy(&[2, 2], &[1.0, 2.0, 3.0, 4.0]);
/// let array = sinew_mesh::parse_npy("u.npy", &bytes)?;
/// assert_eq!(array.shape, [2, 2]);
/// # Ok::<(), sinew_mesh::MeshError>(())
/// ```
pub fn parse_npy(file: &str, bytes: &[u8]) -> Result<NpyArray, MeshError> {
    let mut cursor = Cursor::new(bytes);
    cursor.encoding = Encoding::Little;
    let array = read(&mut cursor).map_err(|problem| cursor.fault(problem));
    array.map_err(|fault| MeshError::in_file(file, fault))
}

fn read(cursor: &mut Cursor<'_>) -> Result<NpyArray> {
    let magic = cursor.take(MAGIC.len(), "npy magic bytes")?;
    Refusal::require(magic == MAGIC, "the bytes \\x93NUMPY", magic)?;
    let version = cursor.take(2, "npy version")?[0];
    let length_type = if version == 1 { NumberType::U16 } else { NumberType::U32 };
    let length = cursor.count(length_type, "the length of the npy header")?;
    let header = cursor.take(length, "the npy header")?;
    let header = str::from_utf8(header).map_err(|_| Refusal::expected("an npy header", header))?;

    let (kind, encoding) = number_type(header)?;
    let shape = shape(header)?;
    let fortran = match entry(header, "'fortran_order':")? {
        text if text.starts_with("True") => true,
        text if text.starts_with("False") => false,
        text => return Err(Refusal::expected("True or False", text)),
    };
    cursor.encoding = encoding;
    let count = shape.iter().fold(1usize, |product, &length| product.saturating_mul(length));
    let mut values = cursor.numbers(kind, count, "numbers of the array")?;
    if fortran && shape.len() > 1 {
        values = values.select(c_order(count, &shape));
    }
    Ok(NpyArray { shape, values })
}

/// An array of 64-bit floats as an npy file, the last index fastest.
///
/// # Panics
/// When the number of values is not the product of the shape.
pub fn to_npy(shape: &[usize], values: &[f64]) -> Vec<u8> {
    let count: usize = shape.iter().product();
    assert_eq!(count, values.len(), "shape {shape:?} must fit the values");
    let bytes: Vec<u8> = values.iter().flat_map(|value| value.to_le_bytes()).collect();
    to_npy_of("<f8", shape, &bytes)
}

/// An array of a type that NumPy names so, such as `<i8`, from its bytes as an npy file.
pub fn to_npy_of(descr: &str, shape: &[usize], content: &[u8]) -> Vec<u8> {
    let lengths: String = shape.iter().map(|length| format!("{length}, ")).collect();
    let mut header =
        format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': ({lengths}), }}");
    // Magic, version, length, header and line break together are a multiple of 64 bytes.
    let unpadded = MAGIC.len() + 6 + header.len() + 1;
    header.push_str(&" ".repeat(unpadded.next_multiple_of(64) - unpadded));
    header.push('\n');
    let length = (header.len() as u32).to_le_bytes();
    [MAGIC, &[2, 0], &length, header.as_bytes(), content].concat()
}

/// Text after a key of the header.
fn entry<'h>(header: &'h str, key: &'static str) -> Result<&'h str> {
    let value = header.split_once(key).map(|(_, value)| value.trim_start());
    value.ok_or_else(|| Refusal::missing(key))
}

fn number_type(header: &str) -> Result<(NumberType, Encoding)> {
    let text = entry(header, "'descr':")?;
    let descr = text.strip_prefix('\'').and_then(|t| t.split_once('\'')).map_or(text, |(d, _)| d);
    let kind = NumberType::named(descr.get(1..).unwrap_or_default()).ok_or_else(|| {
        let (value, advice) = (excerpt(descr.as_bytes()), "save the array as float64 or int64");
        Refusal::unsupported("npy number type", value, advice)
    })?;
    let encoding = if descr.starts_with('>') { Encoding::Big } else { Encoding::Little };
    Ok((kind, encoding))
}

fn shape(header: &str) -> Result<Vec<usize>> {
    let text = entry(header, "'shape':")?;
    let expected = "a shape such as (3, 4)";
    let inner = text.strip_prefix('(').and_then(|text| text.split_once(')'));
    let (inner, _) = inner.ok_or_else(|| Refusal::expected(expected, text))?;
    let words = inner.split(',').map(str::trim).filter(|word| !word.is_empty());
    let lengths: Result<Vec<usize>, _> = words.map(str::parse).collect();
    match lengths {
        Ok(lengths) if lengths.len() <= MOST_DIMENSIONS => Ok(lengths),
        _ => Err(Refusal::expected(expected, inner)),
    }
}

/// Order of the numbers, last index fastest, in an array whose first index is fastest.
fn c_order(count: usize, shape: &[usize]) -> impl Iterator<Item = usize> {
    let place = move |mut at: usize| {
        let (mut place, mut stride) = (0, count);
        for &length in shape.iter().rev() {
            stride /= length;
            place += at % length * stride;
            at /= length;
        }
        place
    };
    (0..count).map(place)
}
