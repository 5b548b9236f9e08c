//! The scalar types of PLY and their bytes.

use crate::base::convert::Cut;

/// A scalar type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Scalar {
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

/// The order of the bytes of a binary file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Endian {
    Little,
    Big,
}

/// A value of any of the types.
trait Value: Copy {
    /// The value as a coordinate.
    fn real(self) -> f64;

    /// The value as a length or an index: no integer is lost.
    fn whole(self) -> i128;
}

macro_rules! value {
    ($($type:ty)*) => {
        $(impl Value for $type {
            fn real(self) -> f64 {
                self as f64
            }

            fn whole(self) -> i128 {
                self.into()
            }
        })*
    };
}

value!(i8 u8 i16 u16 i32 u32 i64 u64);

impl Value for f32 {
    fn real(self) -> f64 {
        self.into()
    }

    fn whole(self) -> i128 {
        i64::cut(self).into()
    }
}

impl Value for f64 {
    fn real(self) -> f64 {
        self
    }

    fn whole(self) -> i128 {
        i64::cut(self).into()
    }
}

/// Calls `$each` with one value of every row, by its method `$as`. The type is looked at once, not once a value.
macro_rules! decode {
    ($scalar:expr, $endian:expr, $rows:expr, $each:expr, $as:ident) => {
        match $scalar {
            Scalar::I8 => decode!(@ i8, $endian, $rows, $each, $as),
            Scalar::U8 => decode!(@ u8, $endian, $rows, $each, $as),
            Scalar::I16 => decode!(@ i16, $endian, $rows, $each, $as),
            Scalar::U16 => decode!(@ u16, $endian, $rows, $each, $as),
            Scalar::I32 => decode!(@ i32, $endian, $rows, $each, $as),
            Scalar::U32 => decode!(@ u32, $endian, $rows, $each, $as),
            Scalar::I64 => decode!(@ i64, $endian, $rows, $each, $as),
            Scalar::U64 => decode!(@ u64, $endian, $rows, $each, $as),
            Scalar::F32 => decode!(@ f32, $endian, $rows, $each, $as),
            Scalar::F64 => decode!(@ f64, $endian, $rows, $each, $as),
        }
    };
    (@ $type:ty, $endian:expr, $rows:expr, $each:expr, $as:ident) => {
        for bytes in $rows.filter_map(|r| r.first_chunk::<{ size_of::<$type>() }>()) {
            let value = match $endian {
                Endian::Little => <$type>::from_le_bytes(*bytes),
                Endian::Big => <$type>::from_be_bytes(*bytes),
            };
            $each(value.$as());
        }
    };
}

impl Scalar {
    /// The type of a name: every type has two. 64-bit integers are no part of the format, but some programs write them.
    pub(super) fn named(name: &str) -> Option<Scalar> {
        Some(match name {
            "char" | "int8" => Scalar::I8,
            "uchar" | "uint8" => Scalar::U8,
            "short" | "int16" => Scalar::I16,
            "ushort" | "uint16" => Scalar::U16,
            "int" | "int32" => Scalar::I32,
            "uint" | "uint32" => Scalar::U32,
            "int64" => Scalar::I64,
            "uint64" => Scalar::U64,
            "float" | "float32" => Scalar::F32,
            "double" | "float64" => Scalar::F64,
            _ => return None,
        })
    }

    /// The bytes of a value.
    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// Whether the type is one of integers.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Scalar::F32 | Scalar::F64)
    }

    /// Decodes the value at the start of each row, as a coordinate.
    pub(super) fn reals<'a>(self, endian: Endian, rows: impl Iterator<Item = &'a [u8]>, mut each: impl FnMut(f64)) {
        decode!(self, endian, rows, each, real)
    }

    /// Decodes the value at the start of each row, as a length or an index: no integer is lost.
    pub(super) fn integers<'a>(self, endian: Endian, rows: impl Iterator<Item = &'a [u8]>, mut each: impl FnMut(i128)) {
        decode!(self, endian, rows, each, whole)
    }
}
