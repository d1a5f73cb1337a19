//! The number types of file formats.

use super::cursor::{Encoding, Result, number};
use crate::FieldValues;

/// A number type as it is stored in a file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum NumberType {
    I8,
    U8,
    I16,
    U16,
    I32,
    U32,
    I64,
    U64,
    F32,
    F64,
}

impl NumberType {
    /// The type with a name of legacy VTK, VTK XML or NumPy, in small letters.
    pub(super) fn named(name: &str) -> Option<NumberType> {
        Some(match name {
            "char" | "signed_char" | "int8" | "i1" => NumberType::I8,
            "unsigned_char" | "uint8" | "u1" | "b1" => NumberType::U8,
            "short" | "int16" | "i2" => NumberType::I16,
            "unsigned_short" | "uint16" | "u2" => NumberType::U16,
            // Identifiers are always written with 32 bits.
            "int" | "vtkidtype" | "int32" | "i4" => NumberType::I32,
            "unsigned_int" | "uint32" | "u4" => NumberType::U32,
            "long" | "long_long" | "int64" | "i8" => NumberType::I64,
            "unsigned_long" | "unsigned_long_long" | "uint64" | "u8" => NumberType::U64,
            "float" | "float32" | "f4" => NumberType::F32,
            "double" | "float64" | "f8" => NumberType::F64,
            _ => return None,
        })
    }

    /// Bytes of one number in binary files.
    pub(super) fn size(self) -> usize {
        use NumberType::*;
        match self {
            I8 | U8 => 1,
            I16 | U16 => 2,
            I32 | U32 | F32 => 4,
            I64 | U64 | F64 => 8,
        }
    }

    /// Words as numbers.
    pub(super) fn parse<'w>(
        self,
        words: impl Iterator<Item = Result<&'w [u8]>>,
        expected: &'static str,
    ) -> Result<FieldValues> {
        if matches!(self, NumberType::F32 | NumberType::F64) {
            let numbers: Result<_> = words.map(|word| number(word?, expected)).collect();
            return numbers.map(FieldValues::Float);
        }
        let numbers: Result<_> = words.map(|word| number(word?, expected)).collect();
        numbers.map(FieldValues::Integer)
    }

    /// Decodes whole numbers, little-endian ones unless the encoding is the big-endian one; a trailing rest of bytes is left
    /// out. `Err` holds the index of an unsigned number beyond the largest signed one.
    pub(super) fn decode(self, bytes: &[u8], encoding: Encoding) -> Result<FieldValues, usize> {
        use FieldValues::{Float, Integer};
        Ok(match self {
            NumberType::I8 => Integer(numbers(bytes, encoding, |b| i8::from_le_bytes(b).into())),
            NumberType::U8 => Integer(numbers(bytes, encoding, |b| u8::from_le_bytes(b).into())),
            NumberType::I16 => Integer(numbers(bytes, encoding, |b| i16::from_le_bytes(b).into())),
            NumberType::U16 => Integer(numbers(bytes, encoding, |b| u16::from_le_bytes(b).into())),
            NumberType::I32 => Integer(numbers(bytes, encoding, |b| i32::from_le_bytes(b).into())),
            NumberType::U32 => Integer(numbers(bytes, encoding, |b| u32::from_le_bytes(b).into())),
            NumberType::I64 => Integer(numbers(bytes, encoding, i64::from_le_bytes)),
            NumberType::U64 => {
                let signed = numbers(bytes, encoding, i64::from_le_bytes);
                // Those beyond have the bit of the sign.
                match signed.iter().position(|&number| number < 0) {
                    Some(index) => return Err(index),
                    None => Integer(signed),
                }
            }
            NumberType::F32 => Float(numbers(bytes, encoding, |b| f32::from_le_bytes(b).into())),
            NumberType::F64 => Float(numbers(bytes, encoding, f64::from_le_bytes)),
        })
    }
}

/// Numbers of little-endian bytes, or of big-endian ones that are reversed.
fn numbers<T, const SIZE: usize>(
    bytes: &[u8],
    encoding: Encoding,
    number: impl Fn([u8; SIZE]) -> T,
) -> Vec<T> {
    let ordered = |&(mut bytes): &[u8; SIZE]| {
        if encoding == Encoding::Big {
            bytes.reverse();
        }
        number(bytes)
    };
    bytes.as_chunks().0.iter().map(ordered).collect()
}
