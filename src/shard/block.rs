//! One shard of one segment: columns to bytes and back. The layout is in `format`.

use std::io::Read;

use super::format::SHARD;
use super::varint::{Column, put, put_signed};
use crate::base::ids::TriangleId;
use crate::scene::reflectance::{BINS, Bin, BinSum};

/// A shard's records, ascending, as the reader hands them out.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Block {
    /// `(triangle, frames that saw it, records)`, ascending by triangle.
    pub triangles: Vec<(TriangleId, u32, u32)>,
    /// The records of these triangles, one after the other.
    pub records: Vec<(Bin, BinSum)>,
}

/// Columns of a block being written.
#[derive(Debug, Default)]
pub struct Columns {
    triangles: Vec<u8>,
    bins: Vec<u8>,
    counts: Vec<u8>,
    radiance: [Vec<u8>; 3],
    last_triangle: TriangleId,
    last_green: i64,
}

impl Columns {
    /// Begins the block of a shard.
    pub fn begin(&mut self, shard: u32) {
        [&mut self.triangles, &mut self.bins, &mut self.counts]
            .into_iter()
            .chain(&mut self.radiance)
            .for_each(Vec::clear);
        self.last_triangle = shard * SHARD;
        self.last_green = 0;
    }

    /// Adds a triangle: greater than the one before, with at least one bin, ascending.
    pub fn push(&mut self, triangle: TriangleId, frames: u32, bins: &[(Bin, BinSum)]) {
        put(&mut self.triangles, u64::from(triangle - self.last_triangle));
        put(&mut self.triangles, u64::from(frames));
        put(&mut self.triangles, bins.len() as u64 - 1);
        self.last_triangle = triangle;
        let mut last_bin = 0;
        for (bin, sum) in bins {
            put(&mut self.bins, u64::from(bin - last_bin));
            last_bin = *bin;
            put(&mut self.counts, u64::from(sum.count - 1) << 1 | u64::from(sum.clipped != 0));
            if sum.clipped != 0 {
                put(&mut self.counts, u64::from(sum.clipped));
            }
            let count = u64::from(sum.count);
            let quotient = sum.radiance.map(|s| (s / count) as i64);
            let difference = [quotient[0] - quotient[1], quotient[1] - self.last_green, quotient[2] - quotient[1]];
            self.last_green = quotient[1];
            for ((column, difference), s) in self.radiance.iter_mut().zip(difference).zip(sum.radiance) {
                put_signed(column, difference);
                if count > 1 {
                    put(column, s % count);
                }
            }
        }
    }

    /// The block, uncompressed.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.clear();
        for column in [&self.triangles, &self.bins, &self.counts].into_iter().chain(&self.radiance) {
            put(out, column.len() as u64);
            out.extend_from_slice(column);
        }
    }
}

/// Decodes a block of `triangles` triangles and `records` records. Says what is wrong with one that is not so.
pub fn decode(compressed: &[u8], shard: u32, triangles: u32, records: u32) -> Result<Block, String> {
    let wrong = |what: &str| format!("block of shard {shard}: {what}");
    let mut raw = Vec::new();
    // The numbers of a record take at most 2 + 10 + 3 * 20 bytes, so a bomb stops here.
    let limit = u64::from(triangles) * 20 + u64::from(records) * 72 + 64;
    zstd::stream::read::Decoder::new(compressed)
        .and_then(|d| d.take(limit).read_to_end(&mut raw))
        .map_err(|e| wrong(&format!("not zstd: {e}")))?;
    let mut all = Column::new(&raw);
    let mut column = || all.next().and_then(|n| all.split(n)).ok_or_else(|| wrong("a column is cut short"));
    let (mut heads, mut bins, mut counts) = (column()?, column()?, column()?);
    let mut radiance = [column()?, column()?, column()?];

    let mut block = Block::default();
    let (mut triangle, mut green) = (u64::from(shard) * u64::from(SHARD), 0i64);
    let end = triangle + u64::from(SHARD);
    for i in 0..triangles {
        let head = (|| Some((heads.next()?, heads.next()?, heads.next()?)))();
        let (step, frames, more) = head.ok_or_else(|| wrong("fewer triangles than the index says"))?;
        triangle = triangle
            .checked_add(step)
            .filter(|&t| t < end && (i == 0 || step > 0))
            .ok_or_else(|| wrong("triangles out of order"))?;
        let frames = u32::try_from(frames).map_err(|_| wrong("a frame count past 32 bits"))?;
        let mut bin = 0u64;
        if more >= BINS as u64 {
            return Err(wrong("more records than a map has bins"));
        }
        for j in 0..=more {
            let step = bins.next().filter(|&s| j == 0 || s > 0);
            bin = step
                .and_then(|s| bin.checked_add(s))
                .filter(|&b| b < BINS as u64)
                .ok_or_else(|| wrong("bins out of order"))?;
            let sum = next_sum(&mut counts, &mut radiance, &mut green).ok_or_else(|| wrong("a sum that cannot be"))?;
            block.records.push((bin as Bin, sum));
        }
        block.triangles.push((triangle as TriangleId, frames, more as u32 + 1));
    }
    let left = [heads, bins, counts].iter().chain(&radiance).any(|c| !c.is_empty()) || !all.is_empty();
    if left || block.records.len() != records as usize {
        return Err(wrong("more bytes than the index says"));
    }
    Ok(block)
}

/// One record's sums.
#[inline]
fn next_sum(counts: &mut Column<'_>, radiance: &mut [Column<'_>; 3], green: &mut i64) -> Option<BinSum> {
    let head = counts.next()?;
    let count = u32::try_from((head >> 1).checked_add(1)?).ok()?;
    let clipped = if head & 1 == 1 { u32::try_from(counts.next()?).ok().filter(|&c| c > 0)? } else { 0 };
    let [red, mid, blue] = radiance;
    let channel = |column: &mut Column<'_>, base: i64| -> Option<(i64, u64)> {
        let quotient = column.next_signed()?.checked_add(base).filter(|&q| q >= 0)?;
        let remainder = if count > 1 { column.next()?.min(u64::from(count) - 1) } else { 0 };
        Some((quotient, (quotient as u64).checked_mul(u64::from(count))?.checked_add(remainder)?))
    };
    let (q, g) = channel(mid, *green)?;
    *green = q;
    let (r, b) = (channel(red, q)?.1, channel(blue, q)?.1);
    Some(BinSum { radiance: [r, g, b], count, clipped })
}
