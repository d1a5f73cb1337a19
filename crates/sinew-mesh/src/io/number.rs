//! The number types of file formats.

use super::cursor::{Endian, number};
use crate::{FieldValues, Problem};

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
        words: impl Iterator<Item = Result<&'w [u8], Problem>>,
        expected: &'static str,
    ) -> Result<FieldValues, Problem> {
        Ok(match self {
            NumberType::F32 | NumberType::F64 => {
                let numbers = words.map(|word| number(word?, expected));
                FieldValues::Float(numbers.collect::<Result<_, _>>()?)
            }
            _ => {
                let numbers = words.map(|word| number(word?, expected));
                FieldValues::Integer(numbers.collect::<Result<_, _>>()?)
            }
        })
    }

    /// Decodes whole numbers; a trailing rest of bytes is left out. `Err` holds the index of
    /// an unsigned number beyond the largest signed one.
    pub(super) fn decode(self, bytes: &[u8], endian: Endian) -> Result<FieldValues, usize> {
        /// The numbers as `$wide`, read as `$narrow`.
        macro_rules! numbers {
            ($narrow:ty) => {
                bytes.as_chunks().0.iter().map(|&chunk| match endian {
                    Endian::Little => <$narrow>::from_le_bytes(chunk),
                    Endian::Big => <$narrow>::from_be_bytes(chunk),
                })
            };
        }
        macro_rules! integers {
            ($narrow:ty) => {
                FieldValues::Integer(numbers!($narrow).map(i64::from).collect())
            };
        }
        Ok(match self {
            NumberType::I8 => integers!(i8),
            NumberType::U8 => integers!(u8),
            NumberType::I16 => integers!(i16),
            NumberType::U16 => integers!(u16),
            NumberType::I32 => integers!(i32),
            NumberType::U32 => integers!(u32),
            NumberType::I64 => integers!(i64),
            NumberType::U64 => {
                let signed = |(index, n)| i64::try_from(n).map_err(|_| index);
                FieldValues::Integer(
                    numbers!(u64).enumerate().map(signed).collect::<Result<_, _>>()?,
                )
            }
            NumberType::F32 => FieldValues::Float(numbers!(f32).map(f64::from).collect()),
            NumberType::F64 => FieldValues::Float(numbers!(f64).collect()),
        })
    }
}
