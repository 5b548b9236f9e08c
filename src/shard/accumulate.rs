//! Observations summed by (triangle, bin): first within a tile, where most of them meet, then over a frame, then over a
//! group of frames.
//!
//! What is held is bounded at each step. A frame whose rows grow past a bound is handed on in parts, and a group is
//! written in as many segments as memory asks for. However it is cut, a frame counts once for each triangle that it saw.

use std::cmp::Reverse;
use std::collections::BinaryHeap;
use std::collections::binary_heap::PeekMut;
use std::io::{self, Write};

use super::format::{Entry, SHARD};
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
    /// Frames that saw the triangle, to be added up over its records: 1 for the first of a frame's, 0 for the others.
    pub frames: u16,
    /// The sums.
    pub sum: BinSum,
}

impl Record {
    /// Bytes of memory that one holds.
    pub const BYTES: u64 = size_of::<Record>() as u64;

    fn key(&self) -> u64 {
        u64::from(self.triangle) << 16 | u64::from(self.bin)
    }
}

/// The records of one frame or of a part of it, ascending by (triangle, bin), each once.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct FrameRows {
    /// The records.
    pub records: Vec<Record>,
}

impl FrameRows {
    /// Bytes of memory held.
    pub fn bytes(&self) -> u64 {
        self.records.capacity() as u64 * Record::BYTES
    }
}

/// Gathers a frame's observations.
#[derive(Debug)]
pub struct Accumulator {
    tile: Vec<Record>,
    frame: Vec<Record>,
    /// Records of a frame beyond which a part of it is handed on.
    most: usize,
}

impl Accumulator {
    /// Gathers parts of about this many bytes; a tile's records come on top.
    pub fn new(bytes: u64) -> Self {
        let most = usize::try_from(bytes / Record::BYTES).unwrap_or(usize::MAX).max(1);
        Accumulator { tile: Vec::new(), frame: Vec::new(), most }
    }

    /// Adds one observation of the current tile.
    #[inline]
    pub fn observe(&mut self, triangle: TriangleId, bin: Bin, sum: BinSum) {
        self.tile.push(Record { triangle, bin, frames: 0, sum });
    }

    /// Ends a tile: what fell into the same bin of the same triangle becomes one record. Gives the rows so far if they
    /// have become too many to be held.
    pub fn end_tile(&mut self) -> Option<FrameRows> {
        sum_equal_keys(&mut self.tile);
        if self.frame.len() + self.tile.len() > self.most {
            sum_equal_keys(&mut self.frame);
        }
        // Less than half of it came of adding up: it would soon be full again.
        let full = self.frame.len() + self.tile.len() > self.most && self.frame.len() > self.most / 2;
        let part = full.then(|| self.take());
        self.frame.append(&mut self.tile);
        part
    }

    /// Ends the frame and takes what rows there are left of it.
    pub fn finish(&mut self) -> FrameRows {
        sum_equal_keys(&mut self.tile);
        self.frame.append(&mut self.tile);
        sum_equal_keys(&mut self.frame);
        self.take()
    }

    /// The frame's records, added up.
    fn take(&mut self) -> FrameRows {
        let mut records = std::mem::take(&mut self.frame);
        records.shrink_to_fit();
        let mut last = None;
        for record in &mut records {
            record.frames = u16::from(last.replace(record.triangle) != Some(record.triangle));
        }
        FrameRows { records }
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

/// The records of a group of frames, gathered until a segment is written.
#[derive(Debug, Default)]
pub struct GroupRows {
    parts: Vec<FrameRows>,
    /// Records in each shard.
    shards: Vec<u32>,
    /// The triangles that earlier parts of a frame have counted, while further ones of it come: a bit each.
    counted: Vec<u64>,
}

impl GroupRows {
    /// Adds a frame's rows, or a part of them: `more` says that further parts follow.
    pub fn add(&mut self, mut rows: FrameRows, more: bool) {
        if more || !self.counted.is_empty() {
            self.count_once(&mut rows);
        }
        if !more {
            self.counted = Vec::new();
        }
        for own in rows.records.chunk_by(|a, b| a.triangle / SHARD == b.triangle / SHARD) {
            let shard = (own[0].triangle / SHARD) as usize;
            self.shards.resize(self.shards.len().max(shard + 1), 0);
            self.shards[shard] += own.len() as u32;
        }
        if !rows.records.is_empty() {
            self.parts.push(rows);
        }
    }

    /// Takes the frame off records of triangles that it has been counted for.
    fn count_once(&mut self, rows: &mut FrameRows) {
        for record in rows.records.iter_mut().filter(|r| r.frames > 0) {
            let (word, bit) = ((record.triangle / 64) as usize, 1 << (record.triangle % 64));
            self.counted.resize(self.counted.len().max(word + 1), 0);
            if self.counted[word] & bit != 0 {
                record.frames = 0;
            }
            self.counted[word] |= bit;
        }
    }

    /// Whether nothing has been gathered since the last segment.
    pub fn is_empty(&self) -> bool {
        self.parts.is_empty()
    }

    /// Bytes of memory held, and of what writing them takes besides: the columns of a shard's block, the block, and the
    /// block compressed.
    pub fn bytes(&self) -> u64 {
        let widest = self.shards.iter().max().copied().unwrap_or(0);
        let lists = (size_of_val(self.shards.as_slice()) + size_of_val(self.counted.as_slice())) as u64;
        self.parts.iter().map(FrameRows::bytes).sum::<u64>() + u64::from(widest) * WRITTEN + lists
    }

    /// Bytes that it would hold, at most, with these rows too.
    pub fn bytes_with(&self, rows: &FrameRows) -> u64 {
        self.bytes() + rows.bytes() + rows.records.len() as u64 * WRITTEN
    }

    /// Bytes that it holds at most, with what writing takes, where nothing but rows of this many bytes are in it.
    pub fn most(rows: u64) -> u64 {
        rows.saturating_add(rows / Record::BYTES * WRITTEN)
    }

    /// Writes what was gathered as a segment and lets go of it. Gives the segment's index.
    pub fn write<W: Write>(&mut self, out: W) -> io::Result<(W, Vec<Entry>)> {
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
/// fewer in what becomes of it, and room in vectors that grow.
const WRITTEN: u64 = 60;
