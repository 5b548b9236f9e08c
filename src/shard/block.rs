//! The block of one shard in one segment: columns to bytes and back. The layout is in `format`.

use std::io::Read;

use super::varint::{Column, put, put_signed};
use crate::base::convert::to_usize;
use crate::base::ids::{ShardId, TriangleId};
use crate::scene::cells::CELLS;
use crate::scene::reflectance::{Bin, BinSum};

/// A shard's records in one segment, ascending.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Block {
    /// The triangles, ascending.
    pub triangles: Vec<BlockTriangle>,
    /// The bins and sums of these triangles' records, triangle after triangle.
    pub records: Vec<(Bin, BinSum)>,
}

/// A triangle of a block.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct BlockTriangle {
    /// The triangle.
    pub triangle: TriangleId,
    /// Frames that saw the triangle.
    pub frames: u32,
    /// Number of the triangle's records in the block.
    pub records: u32,
}

/// The columns of a block that is being written.
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
    pub fn begin(&mut self, shard: ShardId) {
        [&mut self.triangles, &mut self.bins, &mut self.counts]
            .into_iter()
            .chain(&mut self.radiance)
            .for_each(Vec::clear);
        self.last_triangle = shard.first();
        self.last_green = 0;
    }

    /// Adds a triangle: greater than the one before, with at least one bin, ascending.
    pub fn push(&mut self, triangle: TriangleId, frames: u32, bins: &[(Bin, BinSum)]) {
        put(&mut self.triangles, u64::from(triangle.0 - self.last_triangle.0));
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

    /// Writes the uncompressed block into `out`, which is overwritten.
    pub fn write(&self, out: &mut Vec<u8>) {
        out.clear();
        for column in [&self.triangles, &self.bins, &self.counts].into_iter().chain(&self.radiance) {
            put(out, column.len() as u64);
            out.extend_from_slice(column);
        }
    }
}

/// Decodes a block of `triangles` triangles and `records` records.
///
/// # Errors
/// In words, what is wrong with the block.
pub fn decode(compressed: &[u8], shard: ShardId, triangles: u32, records: u32) -> Result<Block, String> {
    let wrong = |what: &str| format!("block of shard {shard}: {what}");
    if shard > ShardId::LAST {
        return Err(wrong("no triangle is in that shard"));
    }
    // The numbers of a record take at most 2 + 10 + 3 * 20 bytes, so a bomb stops here. A vector that grows would hold twice as
    // much; what is set aside and not filled takes no memory.
    let limit = u64::from(triangles) * 20 + u64::from(records) * 72 + 64;
    let mut raw = Vec::new();
    raw.try_reserve_exact(to_usize(limit)).map_err(|_| wrong("there is no memory for as much as the index says"))?;
    zstd::stream::read::Decoder::new(compressed)
        .and_then(|d| d.take(limit).read_to_end(&mut raw))
        .map_err(|e| wrong(&format!("not zstd: {e}")))?;
    let mut all = Column::new(&raw);
    let mut column = || all.next().and_then(|n| all.split(n)).ok_or_else(|| wrong("a column is cut short"));
    let (mut heads, mut bins, mut counts) = (column()?, column()?, column()?);
    let mut radiance = [column()?, column()?, column()?];

    let mut block = Block::default();
    // The triangle's position in the shard.
    let (mut slot, mut green) = (0u32, 0i64);
    for i in 0..triangles {
        let head = (|| Some((heads.next()?, heads.next()?, heads.next()?)))();
        let (step, frames, more) = head.ok_or_else(|| wrong("fewer triangles than the index says"))?;
        slot = (u64::from(slot).checked_add(step))
            .and_then(|s| u32::try_from(s).ok())
            .filter(|&s| s < ShardId::TRIANGLES && (i == 0 || step > 0))
            .ok_or_else(|| wrong("triangles out of order"))?;
        let frames = u32::try_from(frames).map_err(|_| wrong("a frame count past 32 bits"))?;
        let more = u16::try_from(more)
            .ok()
            .filter(|&more| usize::from(more) < CELLS)
            .ok_or_else(|| wrong("more records than a map has cells"))?;
        let mut bin: Bin = 0;
        for j in 0..=more {
            let step = bins.next().filter(|&s| j == 0 || s > 0);
            bin = step
                .and_then(|s| u64::from(bin).checked_add(s))
                .and_then(|b| Bin::try_from(b).ok())
                .filter(|&b| usize::from(b) < CELLS)
                .ok_or_else(|| wrong("bins out of order"))?;
            if block.records.len() == records as usize {
                return Err(wrong("more records than the index says"));
            }
            let sum = next_sum(&mut counts, &mut radiance, &mut green).ok_or_else(|| wrong("a sum that cannot be"))?;
            block.records.push((bin, sum));
        }
        let triangle = TriangleId(shard.first().0 + slot);
        block.triangles.push(BlockTriangle { triangle, frames, records: u32::from(more) + 1 });
    }
    let left = [heads, bins, counts].iter().chain(&radiance).any(|c| !c.is_empty()) || !all.is_empty();
    if left || block.records.len() != records as usize {
        return Err(wrong("more bytes than the index says"));
    }
    Ok(block)
}

/// The sums of the next record.
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
