//! Merges any number of segments, shard by shard, into the maps of their triangles.

use super::format::SHARD;
use super::reader::Segment;
use crate::base::Result;
use crate::base::ids::TriangleId;
use crate::scene::reflectance::{Bin, BinSum, SparseMap};

/// The maps of a shard's observed triangles.
#[derive(Debug, Default, PartialEq)]
pub struct ShardMaps {
    /// Which shard.
    pub shard: u32,
    /// `(triangle, frames that saw it, its map)`, ascending by triangle.
    pub triangles: Vec<(TriangleId, u32, SparseMap)>,
}

/// The maps of one shard out of all segments. The order of segments does not matter.
pub fn merge_shard<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32) -> Result<ShardMaps> {
    let mut frames = vec![0u32; SHARD as usize];
    let mut bins: Vec<Vec<(Bin, BinSum)>> = vec![Vec::new(); SHARD as usize];
    for segment in segments {
        let Some(block) = segment.block(shard)? else { continue };
        let mut records = block.records.as_slice();
        for (triangle, seen, count) in block.triangles {
            let (own, rest) = records.split_at(count as usize);
            records = rest;
            let slot = (triangle - shard * SHARD) as usize;
            frames[slot] = frames[slot].saturating_add(seen);
            bins[slot].extend_from_slice(own);
        }
    }
    let triangles = bins.into_iter().zip(frames).enumerate().filter(|(_, (b, _))| !b.is_empty());
    let triangles = triangles.map(|(slot, (mut bins, frames))| {
        sum_equal_bins(&mut bins);
        (shard * SHARD + slot as TriangleId, frames, SparseMap { bins })
    });
    Ok(ShardMaps { shard, triangles: triangles.collect() })
}

fn sum_equal_bins(bins: &mut Vec<(Bin, BinSum)>) {
    bins.sort_unstable_by_key(|b| b.0);
    bins.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1.add(&next.1);
        }
        same
    });
}
