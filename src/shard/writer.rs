//! Writes a segment block by block, in one pass.

use std::io::{self, Write};

use super::block::Columns;
use super::format::{Entry, Hash, MAGIC, VERSION};
use crate::base::convert::to_u32;
use crate::base::ids::{ShardId, TriangleId};
use crate::scene::reflectance::{Bin, BinSum};

/// zstd level of blocks. On aerial data level 3 is 2% smaller than 1 and higher levels gain less than they cost.
const LEVEL: i32 = 3;

/// A segment being written. Triangles must ascend.
pub(crate) struct SegmentWriter<W> {
    out: W,
    offset: u64,
    index: Vec<Entry>,
    columns: Columns,
    /// The open block's shard, triangles and records.
    open: Option<(ShardId, u32, u32)>,
    last: Option<TriangleId>,
    raw: Vec<u8>,
}

impl<W: Write> SegmentWriter<W> {
    /// Begins a segment.
    pub(crate) fn new(mut out: W) -> io::Result<Self> {
        out.write_all(&MAGIC)?;
        out.write_all(&VERSION.to_le_bytes())?;
        Ok(SegmentWriter {
            out,
            offset: super::format::HEADER as u64,
            index: Vec::new(),
            columns: Columns::default(),
            open: None,
            last: None,
            raw: Vec::new(),
        })
    }

    /// Adds a triangle: the number of frames that saw it, and its bins, ascending, each with a count of at least 1. A
    /// triangle without bins is left out.
    ///
    /// # Errors
    /// Those of the sink, and `InvalidInput` if triangles or bins do not ascend.
    pub(crate) fn push(&mut self, triangle: TriangleId, frames: u32, bins: &[(Bin, BinSum)]) -> io::Result<()> {
        let ascending = self.last.is_none_or(|l| l < triangle) && bins.is_sorted_by(|a, b| a.0 < b.0);
        if !ascending || bins.iter().any(|b| b.1.count == 0) {
            return Err(io::Error::new(
                io::ErrorKind::InvalidInput,
                "segment records must ascend and hold observations",
            ));
        }
        if bins.is_empty() {
            return Ok(());
        }
        self.last = Some(triangle);
        let shard = triangle.shard();
        if self.open.is_none_or(|o| o.0 != shard) {
            self.end_block()?;
            self.columns.begin(shard);
            self.open = Some((shard, 0, 0));
        }
        self.columns.push(triangle, frames, bins);
        if let Some((_, triangles, records)) = &mut self.open {
            *triangles += 1;
            *records += to_u32(bins.len());
        }
        Ok(())
    }

    fn end_block(&mut self) -> io::Result<()> {
        let Some((shard, triangles, records)) = self.open.take() else { return Ok(()) };
        self.columns.write(&mut self.raw);
        let compressed = zstd::bulk::compress(&self.raw, LEVEL)?;
        self.out.write_all(&compressed)?;
        let length = compressed.len() as u64;
        let crc = crc32fast::hash(&compressed);
        let mut hash = Hash::default();
        blake3::Hasher::new().update(&self.raw).finalize_xof().fill(&mut hash);
        self.index.push(Entry { shard, triangles, records, crc, offset: self.offset, length, hash });
        self.offset += length;
        Ok(())
    }

    /// Writes index and footer. Gives back the sink, which is not synced yet, and the index. A segment may be empty.
    pub(crate) fn finish(mut self) -> io::Result<(W, Vec<Entry>)> {
        self.end_block()?;
        let index: Vec<u8> = self.index.iter().flat_map(|e| e.to_bytes()).collect();
        self.out.write_all(&index)?;
        self.out.write_all(&self.offset.to_le_bytes())?;
        self.out.write_all(&to_u32(self.index.len()).to_le_bytes())?;
        self.out.write_all(&crc32fast::hash(&index).to_le_bytes())?;
        self.out.write_all(&MAGIC)?;
        Ok((self.out, self.index))
    }
}
