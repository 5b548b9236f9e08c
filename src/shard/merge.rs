//! Merges any number of segments, shard by shard, into the maps of their triangles.
//!
//! Blocks are added up as they come, so that what is held grows with the filled bins of the maps and not with the
//! number of segments.

use super::format::SHARD;
use super::reader::Segment;
use crate::base::Result;
use crate::base::ids::TriangleId;
use crate::scene::reflectance::{Bin, BinSum, FRONT_BINS, SparseMap};

/// The maps of a shard's observed triangles.
#[derive(Debug, Default, PartialEq)]
pub struct ShardMaps {
    /// Which shard.
    pub shard: u32,
    /// `(triangle, frames that saw it, its map)`, ascending by triangle.
    pub triangles: Vec<(TriangleId, u32, SparseMap)>,
}

/// The sums of one triangle so far.
#[derive(Debug, Clone, Default)]
struct Sums {
    frames: u32,
    bins: Vec<(Bin, BinSum)>,
    /// How many of the bins are different ones; those after them have only been put there.
    different: usize,
}

impl Sums {
    fn add(&mut self, frames: u32, bins: &[(Bin, BinSum)]) {
        self.frames = self.frames.saturating_add(frames);
        if self.bins.len() + bins.len() > 2 * self.different + 16 {
            self.settle();
        }
        self.bins.extend_from_slice(bins);
    }

    /// Adds up what fell into the same bin.
    fn settle(&mut self) {
        self.bins.sort_unstable_by_key(|b| b.0);
        self.bins.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1.add(&next.1);
            }
            same
        });
        self.different = self.bins.len();
    }
}

/// Bytes that [`merge_shard`] holds at its largest: all of the shard's records, or as many as its maps have bins, in
/// vectors that grow, and one segment's block as it is decoded.
pub fn merge_need<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32) -> u64 {
    const BIN: u64 = size_of::<(Bin, BinSum)>() as u64;
    let records = || segments.iter().filter_map(|s| s.entry(shard)).map(|e| u64::from(e.records));
    // Twice as many are held before they are added up, in vectors that are half full.
    let sums = (2 * records().sum::<u64>()).min(4 * u64::from(SHARD) * FRONT_BINS as u64) * BIN;
    let block = records().max().unwrap_or(0) * (2 * BIN + 72);
    sums + block + u64::from(SHARD) * size_of::<Sums>() as u64
}

/// The maps of one shard out of all segments. The order of segments does not matter.
pub fn merge_shard<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32) -> Result<ShardMaps> {
    let mut all = vec![Sums::default(); SHARD as usize];
    for segment in segments {
        let Some(block) = segment.block(shard)? else { continue };
        let mut records = block.records.as_slice();
        for (triangle, frames, count) in block.triangles {
            let (own, rest) = records.split_at(count as usize);
            records = rest;
            all[(triangle - shard * SHARD) as usize].add(frames, own);
        }
    }
    let observed = all.into_iter().enumerate().filter(|(_, sums)| !sums.bins.is_empty());
    let triangles = observed.map(|(slot, mut sums)| {
        sums.settle();
        (shard * SHARD + slot as TriangleId, sums.frames, SparseMap { bins: sums.bins })
    });
    Ok(ShardMaps { shard, triangles: triangles.collect() })
}
