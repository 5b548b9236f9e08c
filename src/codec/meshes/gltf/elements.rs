//! The elements of an accessor, read one by one where they lie in the file.

use std::io::{BufReader, Read, Seek, SeekFrom};

use ::gltf::Accessor;
use ::gltf::accessor::{DataType, Dimensions};
use ::gltf::buffer::Source;

use crate::base::input::Input;
use crate::base::{Error, Result};

/// The binary chunk of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk {
    /// The position of the chunk's first byte in the file.
    pub start: u64,
    /// How many bytes it has.
    pub length: u64,
}

/// Where elements lie in a file.
#[derive(Debug)]
pub(super) struct Elements {
    start: u64,
    stride: u64,
    size: u64,
    count: u64,
}

impl Elements {
    /// Positions: three 32-bit floats each.
    ///
    /// # Errors
    /// In words: another form; elements that lie beyond the chunk.
    pub(super) fn positions(accessor: &Accessor<'_>, chunk: Option<Chunk>) -> Result<Self, String> {
        if (accessor.data_type(), accessor.dimensions()) != (DataType::F32, Dimensions::Vec3) {
            let found = accessor.data_type();
            return Err(format!("its positions are of type {found:?}; three 32-bit floats are read"));
        }
        Elements::of(accessor, chunk)
    }

    /// Indices: whole numbers of 8, 16 or 32 bits.
    ///
    /// # Errors
    /// Those of [`Elements::positions`].
    pub(super) fn indices(accessor: &Accessor<'_>, chunk: Option<Chunk>) -> Result<Self, String> {
        let whole = matches!(accessor.data_type(), DataType::U8 | DataType::U16 | DataType::U32);
        if !whole || accessor.dimensions() != Dimensions::Scalar {
            return Err(format!("its indices are of type {:?}; whole numbers are read", accessor.data_type()));
        }
        Elements::of(accessor, chunk)
    }

    fn of(accessor: &Accessor<'_>, chunk: Option<Chunk>) -> Result<Self, String> {
        if accessor.sparse().is_some() {
            return Err("its accessor is sparse, which is not read".to_owned());
        }
        let view = accessor.view().ok_or("its accessor has no buffer view")?;
        if let Source::Uri(_) = view.buffer().source() {
            return Err("its buffer is in another file: save it as .glb with everything inside".to_owned());
        }
        let chunk = chunk.ok_or("the file has no binary chunk")?;
        let wide = |number: usize| number as u64;
        let (size, count) = (wide(accessor.size()), wide(accessor.count()));
        let stride = view.stride().map_or(size, wide).max(size);
        let offset = wide(view.offset()).checked_add(wide(accessor.offset()));
        let bytes = count.checked_sub(1).map_or(Some(0), |last| last.checked_mul(stride)?.checked_add(size));
        let end = offset.and_then(|offset| offset.checked_add(bytes?)).filter(|end| *end <= chunk.length);
        if end.is_none() {
            return Err(format!("its {count} elements end beyond the chunk of {} bytes", chunk.length));
        }
        Ok(Elements { start: chunk.start + offset.unwrap_or_default(), stride, size, count })
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
        let failed = |why| Error::io("read", &path)(why);
        file.seek(SeekFrom::Start(self.start)).map_err(failed)?;
        let mut reader = BufReader::with_capacity(1 << 16, file);
        let (size, mut bytes) = (usize::try_from(self.size).unwrap_or(N).min(N), [0; N]);
        let gap = i64::try_from(self.stride - self.size).unwrap_or_default();
        for at in 0..self.count {
            if at > 0 && gap > 0 {
                reader.seek_relative(gap).map_err(failed)?;
            }
            reader.read_exact(&mut bytes[..size]).map_err(failed)?;
            one(bytes)?;
        }
        Ok(())
    }
}
