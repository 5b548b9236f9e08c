//! Observations summed by (triangle, bin): first within a tile, where most of them meet, then over a frame, then over a
//! group of frames.

use std::io::{self, Write};

use super::format::Entry;
use super::writer::SegmentWriter;
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

/// The records of a group of frames, gathered until its segment is written.
#[derive(Debug, Default)]
pub struct GroupRows {
    records: Vec<Record>,
    /// A triangle once for every frame that saw it.
    seen: Vec<TriangleId>,
}

impl GroupRows {
    /// Adds a frame's rows.
    pub fn add(&mut self, frame: FrameRows) {
        let mut last = None;
        for record in &frame.records {
            if last.replace(record.triangle) != Some(record.triangle) {
                self.seen.push(record.triangle);
            }
        }
        self.records.extend(frame.records);
    }

    /// Bytes of memory held.
    pub fn bytes(&self) -> u64 {
        (self.records.capacity() * size_of::<Record>() + self.seen.capacity() * size_of::<TriangleId>()) as u64
    }

    /// Writes the group's segment and empties the group. Gives the segment's index.
    pub fn write<W: Write>(&mut self, out: W) -> io::Result<(W, Vec<Entry>)> {
        sum_equal_keys(&mut self.records);
        self.seen.sort_unstable();
        let mut writer = SegmentWriter::new(out)?;
        let (mut bins, mut seen) = (Vec::new(), self.seen.as_slice());
        for own in self.records.chunk_by(|a, b| a.triangle == b.triangle) {
            let triangle = own[0].triangle;
            let (frames, rest) = seen.split_at(seen.partition_point(|&t| t == triangle));
            seen = rest;
            bins.clear();
            bins.extend(own.iter().map(|r| (r.bin, r.sum)));
            writer.push(triangle, frames.len() as u32, &bins)?;
        }
        (self.records, self.seen) = (Vec::new(), Vec::new());
        writer.finish()
    }
}
