//! Sums observations by (triangle, bin): first within a tile, where most of them meet, then over a frame, then over a group
//! of frames.
//!
//! Each step holds a bounded number of records. A frame whose records grow past a bound is handed on in parts, and a group
//! is written as several segments where memory is short. However a frame is cut, it counts once for each triangle that it
//! saw.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;
use std::io::{self, Write};

use super::format::Entry;
use super::sum::sum_by_key;
use super::writer::SegmentWriter;
use crate::base::Bits;
use crate::base::convert::to_u32;
use crate::base::ids::TriangleId;
use crate::scene::reflectance::{Bin, BinSum};

/// The summed observations of one (triangle, bin).
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Record {
    /// The triangle.
    pub triangle: TriangleId,
    /// The bin of the triangle's map.
    pub bin: Bin,
    /// Frames that saw the triangle, to be added up over its records: 1 in the first of a frame's records, 0 in the others.
    pub frames: u16,
    /// The sums.
    pub sum: BinSum,
}

impl Record {
    /// Bytes of memory that one record holds.
    pub(crate) const BYTES: u64 = size_of::<Record>() as u64;

    fn key(&self) -> u64 {
        u64::from(self.triangle.0) << 16 | u64::from(self.bin)
    }
}

/// The records of one frame or of a part of a frame, ascending by (triangle, bin), each once.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct FrameRecords {
    /// The records.
    pub records: Vec<Record>,
}

impl FrameRecords {
    /// Bytes of memory held.
    pub(crate) fn bytes(&self) -> u64 {
        self.records.capacity() as u64 * Record::BYTES
    }
}

/// Gathers a frame's observations.
#[derive(Debug)]
pub(crate) struct Accumulator {
    tile: Vec<Record>,
    frame: Vec<Record>,
    /// Records of a frame beyond which a part of the frame is handed on.
    most: usize,
}

impl Accumulator {
    /// An accumulator that hands on parts of about this many bytes; a tile's records come on top.
    pub(crate) fn new(bytes: u64) -> Self {
        let most = usize::try_from(bytes / Record::BYTES).unwrap_or(usize::MAX).max(1);
        Accumulator { tile: Vec::new(), frame: Vec::new(), most }
    }

    /// Adds one observation of the current tile.
    #[inline]
    pub(crate) fn observe(&mut self, triangle: TriangleId, bin: Bin, sum: BinSum) {
        self.tile.push(Record { triangle, bin, frames: 0, sum });
    }

    /// Ends a tile: observations in the same bin of the same triangle become one record. Gives the records so far if they
    /// have become too many to hold.
    pub(crate) fn end_tile(&mut self) -> Option<FrameRecords> {
        sum_equal_keys(&mut self.tile);
        if self.frame.len() + self.tile.len() > self.most {
            sum_equal_keys(&mut self.frame);
        }
        // More than half of the records were already distinct: the frame would soon be full again.
        let full = self.frame.len() + self.tile.len() > self.most && self.frame.len() > self.most / 2;
        let part = full.then(|| self.take());
        self.frame.append(&mut self.tile);
        part
    }

    /// Ends the frame and gives the records that are left of it.
    pub(crate) fn finish(&mut self) -> FrameRecords {
        sum_equal_keys(&mut self.tile);
        self.frame.append(&mut self.tile);
        sum_equal_keys(&mut self.frame);
        self.take()
    }

    /// The frame's records, added up.
    fn take(&mut self) -> FrameRecords {
        let mut records = std::mem::take(&mut self.frame);
        records.shrink_to_fit();
        let mut last = None;
        for record in &mut records {
            record.frames = u16::from(last.replace(record.triangle) != Some(record.triangle));
        }
        FrameRecords { records }
    }
}

/// Sorts records by key and adds up those of equal key.
pub(super) fn sum_equal_keys(records: &mut Vec<Record>) {
    sum_by_key(records, Record::key, |kept, next| kept.sum.add(&next.sum));
}

/// The records of a group of frames until a segment is written.
#[derive(Debug, Default)]
pub(crate) struct GroupRecords {
    parts: Vec<FrameRecords>,
    /// Number of records in each shard.
    shards: Vec<u32>,
    /// The triangles that earlier parts of a frame have counted, while further parts of the frame follow.
    counted: Bits,
}

impl GroupRecords {
    /// Adds a frame's records, or a part of them: `more` says that further parts follow.
    pub(crate) fn add(&mut self, mut part: FrameRecords, more: bool) {
        if more || !self.counted.is_empty() {
            self.count_once(&mut part);
        }
        if !more {
            self.counted = Bits::default();
        }
        for own in part.records.chunk_by(|a, b| a.triangle.shard() == b.triangle.shard()) {
            let shard = own[0].triangle.shard().index();
            self.shards.resize(self.shards.len().max(shard + 1), 0);
            self.shards[shard] += to_u32(own.len());
        }
        if !part.records.is_empty() {
            self.parts.push(part);
        }
    }

    /// Sets `frames` to 0 in records of triangles that an earlier part of the frame has counted.
    fn count_once(&mut self, part: &mut FrameRecords) {
        for record in part.records.iter_mut().filter(|r| r.frames > 0) {
            if !self.counted.insert_new(record.triangle) {
                record.frames = 0;
            }
        }
    }

    /// Whether no record has been gathered since the last segment.
    pub(crate) fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Bytes of memory held, and those that writing takes besides: the columns of a shard's block, the block, and the
    /// compressed block.
    pub(crate) fn bytes(&self) -> u64 {
        let widest = self.shards.iter().max().copied().unwrap_or(0);
        let lists = size_of_val(self.shards.as_slice()) as u64 + self.counted.held();
        self.parts.iter().map(FrameRecords::bytes).sum::<u64>() + u64::from(widest) * WRITTEN + lists
    }

    /// Bytes that the group would hold, at most, with these records too.
    pub(crate) fn bytes_with(&self, part: &FrameRecords) -> u64 {
        self.bytes() + part.bytes() + part.records.len() as u64 * WRITTEN
    }

    /// Bytes that a group holds at most, writing included, whose records take this many bytes.
    pub(crate) fn most(bytes: u64) -> u64 {
        bytes.saturating_add(bytes / Record::BYTES * WRITTEN)
    }

    /// Writes the records as a segment and drops them. Gives the segment's index.
    pub(crate) fn write<W: Write>(&mut self, out: W) -> io::Result<(W, Vec<Entry>)> {
        let parts = std::mem::take(&mut self.parts);
        self.shards.clear();
        let mut writer = SegmentWriter::new(out)?;
        let mut rest: Vec<&[Record]> = parts.iter().map(|part| part.records.as_slice()).collect();
        let first = |(part, records): (usize, &&[Record])| records.first().map(|r| Reverse((r.key(), part)));
        let mut heads: BinaryHeap<Reverse<(u64, usize)>> = rest.iter().enumerate().filter_map(first).collect();
        let (mut open, mut frames, mut bins): (Option<TriangleId>, u32, Vec<(Bin, BinSum)>) = Default::default();
        while let Some(mut head) = heads.peek_mut() {
            let part = head.0.1;
            let Some((record, others)) = rest[part].split_first() else {
                PeekMut::pop(head);
                continue;
            };
            rest[part] = others;
            match others.first() {
                Some(next) => head.0.0 = next.key(),
                None => drop(PeekMut::pop(head)),
            }
            if open != Some(record.triangle) {
                if let Some(triangle) = open.replace(record.triangle) {
                    writer.push(triangle, frames, &bins)?;
                }
                frames = 0;
                bins.clear();
            }
            frames += u32::from(record.frames);
            match bins.last_mut() {
                Some((bin, sum)) if *bin == record.bin => sum.add(&record.sum),
                _ => bins.push((record.bin, record.sum)),
            }
        }
        if let Some(triangle) = open {
            writer.push(triangle, frames, &bins)?;
        }
        writer.finish()
    }
}

/// Bytes that writing takes per record of the shard that is being written: about 15 in the columns, as many in the block,
/// fewer in the compressed block, and spare capacity in vectors that grow.
const WRITTEN: u64 = 60;
