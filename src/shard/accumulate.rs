//! Observations of one frame, summed by (triangle, bin): first within a tile, where most of them meet, then over the
//! frame.

use crate::base::ids::TriangleId;
use crate::scene::reflectance::{Bin, BinSum};

/// What one (triangle, bin) received.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Record {
    /// The triangle.
    pub triangle: TriangleId,
    /// The bin of its map.
    pub bin: Bin,
    /// The sums.
    pub sum: BinSum,
}

impl Record {
    fn key(&self) -> u64 {
        u64::from(self.triangle) << 16 | u64::from(self.bin)
    }
}

/// The records of one frame, ascending by (triangle, bin), each once.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FrameRows {
    /// The records.
    pub records: Vec<Record>,
}

impl FrameRows {
    /// Bytes of memory held.
    pub fn bytes(&self) -> u64 {
        (self.records.capacity() * size_of::<Record>()) as u64
    }
}

/// Gathers a frame's observations; reused from frame to frame.
#[derive(Debug, Default)]
pub struct Accumulator {
    tile: Vec<Record>,
    frame: Vec<Record>,
}

impl Accumulator {
    /// Adds one observation of the current tile.
    #[inline]
    pub fn observe(&mut self, triangle: TriangleId, bin: Bin, sum: BinSum) {
        self.tile.push(Record { triangle, bin, sum });
    }

    /// Ends a tile: what fell into the same bin of the same triangle becomes one record.
    pub fn end_tile(&mut self) {
        sum_equal_keys(&mut self.tile);
        self.frame.append(&mut self.tile);
    }

    /// Ends the frame and takes its rows.
    pub fn finish(&mut self) -> FrameRows {
        self.end_tile();
        sum_equal_keys(&mut self.frame);
        FrameRows { records: self.frame.drain(..).collect() }
    }
}

/// Sorts records by key and adds up those of equal key.
pub(super) fn sum_equal_keys(records: &mut Vec<Record>) {
    records.sort_unstable_by_key(Record::key);
    records.dedup_by(|next, kept| {
        let same = next.key() == kept.key();
        if same {
            kept.sum.add(&next.sum);
        }
        same
    });
}
