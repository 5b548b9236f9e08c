//! The scalar types of PLY and their bytes.

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

/// The order of a binary file's bytes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Endian {
    Little,
    Big,
}

/// Calls `$each` with one value of every record, as `$to`. The type is looked at once, not once a value.
macro_rules! decode {
    ($scalar:expr, $endian:expr, $records:expr, $each:expr, $to:ty) => {
        match $scalar {
            Scalar::I8 => decode!(@ i8, $endian, $records, $each, $to),
            Scalar::U8 => decode!(@ u8, $endian, $records, $each, $to),
            Scalar::I16 => decode!(@ i16, $endian, $records, $each, $to),
            Scalar::U16 => decode!(@ u16, $endian, $records, $each, $to),
            Scalar::I32 => decode!(@ i32, $endian, $records, $each, $to),
            Scalar::U32 => decode!(@ u32, $endian, $records, $each, $to),
            Scalar::I64 => decode!(@ i64, $endian, $records, $each, $to),
            Scalar::U64 => decode!(@ u64, $endian, $records, $each, $to),
            Scalar::F32 => decode!(@ f32, $endian, $records, $each, $to),
            Scalar::F64 => decode!(@ f64, $endian, $records, $each, $to),
        }
    };
    (@ $type:ty, $endian:expr, $records:expr, $each:expr, $to:ty) => {
        for bytes in $records.filter_map(|r| r.first_chunk::<{ size_of::<$type>() }>()) {
            let value = match $endian {
                Endian::Little => <$type>::from_le_bytes(*bytes),
                Endian::Big => <$type>::from_be_bytes(*bytes),
            };
            $each(value as $to);
        }
    };
}

impl Scalar {
    /// The type of either of its names. 64-bit integers are no part of the format, but some programs write them.
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

    /// Bytes of one value.
    pub(super) fn size(self) -> usize {
        match self {
            Scalar::I8 | Scalar::U8 => 1,
            Scalar::I16 | Scalar::U16 => 2,
            Scalar::I32 | Scalar::U32 | Scalar::F32 => 4,
            Scalar::I64 | Scalar::U64 | Scalar::F64 => 8,
        }
    }

    /// Whether it counts.
    pub(super) fn is_integer(self) -> bool {
        !matches!(self, Scalar::F32 | Scalar::F64)
    }

    /// Decodes the value at the start of each record, as coordinates are read.
    pub(super) fn reals<'a>(self, endian: Endian, records: impl Iterator<Item = &'a [u8]>, mut each: impl FnMut(f64)) {
        decode!(self, endian, records, each, f64)
    }

    /// Decodes the value at the start of each record, as lengths and indices are read: no integer is lost.
    pub(super) fn integers<'a>(
        self,
        endian: Endian,
        records: impl Iterator<Item = &'a [u8]>,
        mut each: impl FnMut(i128),
    ) {
        decode!(self, endian, records, each, i128)
    }
}
