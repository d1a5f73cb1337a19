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
        // The compiler knows the width, so that the loop copies vectors.
        match self.size() {
            1 => self.widened::<1>(bytes, encoding),
            2 => self.widened::<2>(bytes, encoding),
            4 => self.widened::<4>(bytes, encoding),
            _ => self.widened::<8>(bytes, encoding),
        }
    }

    fn widened<const SIZE: usize>(
        self,
        bytes: &[u8],
        encoding: Encoding,
    ) -> Result<FieldValues, usize> {
        use NumberType::*;
        let raw = bytes.as_chunks::<SIZE>().0.iter().map(|&(mut number)| {
            if encoding == Encoding::Big {
                number.reverse();
            }
            let mut wide = [0; 8];
            wide[..SIZE].copy_from_slice(&number);
            u64::from_le_bytes(wide)
        });
        let unused = 64 - 8 * SIZE;
        Ok(match self {
            I8 | I16 | I32 | I64 => {
                let with_sign = |bits| (bits << unused) as i64 >> unused;
                FieldValues::Integer(raw.map(with_sign).collect())
            }
            U8 | U16 | U32 => FieldValues::Integer(raw.map(|bits| bits as i64).collect()),
            U64 => {
                let signed = |(index, bits)| i64::try_from(bits).map_err(|_| index);
                FieldValues::Integer(raw.enumerate().map(signed).collect::<Result<_, _>>()?)
            }
            F32 => FieldValues::Float(raw.map(|bits| f32::from_bits(bits as u32).into()).collect()),
            F64 => FieldValues::Float(raw.map(f64::from_bits).collect()),
        })
    }
}
