//! The elements of an accessor, read one by one where they lie in the file.

use std::io::{self, BufReader, ErrorKind, Read};
use std::path::Path;

use ::gltf::Accessor;
use ::gltf::accessor::{DataType, Dimensions};

use super::buffers::Place;
use super::document::Chunk;
use crate::base::input::Input;
use crate::base::shown::brief;
use crate::base::{Error, Result};

/// The binary chunk of a file, if it has one, and the file's folder.
pub(super) type Within<'a> = (Option<Chunk>, &'a Path);

/// Where elements lie.
#[derive(Debug)]
pub(super) struct Elements<'a> {
    place: Place<'a>,
    /// What the buffer is said to have.
    length: u64,
    start: u64,
    stride: u64,
    size: u64,
    count: u64,
}

impl<'a> Elements<'a> {
    /// Positions: three 32-bit floats each.
    ///
    /// # Errors
    /// In words: another form; elements that lie beyond the chunk.
    pub(super) fn positions(accessor: &Accessor<'a>, of: Within<'_>) -> Result<Self, String> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            let found = accessor.data_type();
            return Err(format!("its positions are of type {found:?}; three 32-bit floats are read"));
        }
        Elements::of(accessor, of)
    }

    /// Indices: whole numbers of 8, 16 or 32 bits.
    ///
    /// # Errors
    /// Those of [`Elements::positions`].
    pub(super) fn indices(accessor: &Accessor<'a>, of: Within<'_>) -> Result<Self, String> {
        let whole = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if !whole || accessor.dimensions() != Dimensions::Scalar {
            return Err(format!("its indices are of type {:?}; whole numbers are read", accessor.data_type()));
        }
        Elements::of(accessor, of)
    }

    fn of(accessor: &Accessor<'a>, (chunk, folder): Within<'_>) -> Result<Self, String> {
        if accessor.sparse().is_some() {
            return Err("its accessor is sparse, which is not read".to_owned());
        }
        let view = accessor.view().ok_or("its accessor has no buffer view")?;
        let place = Place::of(&view.buffer(), chunk, folder)?;
        let wide = |number: usize| number as u64;
        let length = wide(view.buffer().length());
        let (size, count) = (wide(accessor.size()), wide(accessor.count()));
        let stride = view.stride().map_or(size, wide).max(size);
        let offset = wide(view.offset()).checked_add(wide(accessor.offset()));
        let bytes = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size));
        let end = offset.and_then(|offset| offset.checked_add(bytes?)).filter(|end| *end <= length);
        if end.is_none() {
            return Err(format!("its {count} elements end beyond the buffer of {length} bytes"));
        }
        Ok(Elements { place, length, start: offset.unwrap_or_default(), stride, size, count })
    }

    /// Gives the three numbers of each element.
    pub(super) fn each(&self, file: &mut Input, mut one: impl FnMut([f32; 3]) -> Result<()>) -> Result<()> {
        self.bytes(file, |bytes: [u8; 12]| {
            let number = |at: usize| f32::from_le_bytes([bytes[at], bytes[at + 1], bytes[at + 2], bytes[at + 3]]);
            one([number(0), number(4), number(8)])
        })
    }

    /// Gives each element as a whole number.
    pub(super) fn each_index(&self, file: &mut Input, mut one: impl FnMut(u64) -> Result<()>) -> Result<()> {
        self.bytes(file, |bytes: [u8; 4]| one(u32::from_le_bytes(bytes).into()))
    }

    /// Gives the bytes of each element, and 0 after them.
    fn bytes<const N: usize>(&self, file: &mut Input, mut one: impl FnMut([u8; N]) -> Result<()>) -> Result<()> {
        let path = file.path().to_owned();
        let failed = |why: io::Error| match why.kind() {
            // What stands in the JSON is no base64, or ends early.
            ErrorKind::InvalidData | ErrorKind::UnexpectedEof => Error::malformed(&path, brief(&why)),
            _ => Error::io("read", &path)(why),
        };
        let from = self.place.open(file, self.start, self.length)?;
        let mut reader = BufReader::with_capacity(1 << 16, from);
        let (size, mut bytes) = (usize::try_from(self.size).unwrap_or(N).min(N), [0; N]);
        let gap = self.stride - self.size;
        for at in 0..self.count {
            if at > 0 && gap > 0 {
                io::copy(&mut (&mut reader).take(gap), &mut io::sink()).map_err(failed)?;
            }
            reader.read_exact(&mut bytes[..size]).map_err(failed)?;
            one(bytes)?;
        }
        Ok(())
    }
}
