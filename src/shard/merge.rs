//! Merges any number of segments, shard by shard, into the maps of their triangles.
//!
//! Blocks are added up as they come, so that what is held grows with the filled bins of the maps and not with the
//! number of segments. A shard that is too much for the memory that there is can be merged in parts, each of a range of its
//! triangles, for which its blocks are decoded once more; a block is always decoded as a whole.

use std::ops::Range;

use super::format::SHARD;
use super::reader::Segment;
use crate::base::Result;
use crate::base::ids::TriangleId;
use crate::scene::reflectance::{Bin, BinSum, FRONT_BINS, SparseMap};

/// The maps of a shard's observed triangles, or of those of a part of it.
#[derive(Debug, Default, PartialEq)]
pub struct ShardMaps {
    /// Which shard.
    pub shard: u32,
    /// Whether further parts of the shard follow.
    pub more: bool,
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

/// Bytes of a bin's sums.
const BIN: u64 = size_of::<(Bin, BinSum)>() as u64;

/// Bytes that the sums of so many triangles take at their largest: all of their records, or as many as their maps have bins.
fn sums(triangles: u64, records: u64) -> u64 {
    // Twice as many are held before they are added up, in vectors that are half full.
    (2 * records).min(4 * triangles * FRONT_BINS as u64) * BIN
}

/// Bytes that merging holds beside the sums: one segment's block as it is decoded, and a place for every triangle.
fn beside<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32) -> u64 {
    let widest = segments.iter().filter_map(|s| s.entry(shard)).map(|e| u64::from(e.records)).max().unwrap_or(0);
    widest * (2 * BIN + 72) + u64::from(SHARD) * (size_of::<Sums>() + size_of::<u64>()) as u64
}

/// Bytes that [`merge_shard`] holds at its largest.
pub fn merge_need<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32) -> u64 {
    let records = segments.iter().filter_map(|s| s.entry(shard)).map(|e| u64::from(e.records)).sum();
    sums(u64::from(SHARD), records) + beside(segments, shard)
}

/// Bytes that merging the same shard triangle by triangle holds at its largest: it cannot be done with less.
pub fn merge_least<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32) -> u64 {
    let blocks = segments.iter().filter(|s| s.entry(shard).is_some()).count() as u64;
    merge_need(segments, shard).min(sums(1, blocks * FRONT_BINS as u64) + beside(segments, shard))
}

/// A range of a shard's triangles, counted from its first, and the bytes that merging it holds at its largest.
pub type Part = (Range<u32>, u64);

/// The parts in which a shard is merged so that none holds more than `room`, or no more than one triangle does: as few as
/// there can be. All blocks are decoded for it, one after the other.
pub fn merge_parts<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32, room: u64) -> Result<Vec<Part>> {
    let mut records = vec![0u64; SHARD as usize];
    for segment in segments {
        for (triangle, _, count) in segment.block(shard)?.into_iter().flat_map(|block| block.triangles) {
            records[(triangle - shard * SHARD) as usize] += u64::from(count);
        }
    }
    let beside = beside(segments, shard);
    let ranges = split(&records, room.saturating_sub(beside));
    Ok(ranges.into_iter().map(|(range, sums)| (range, sums + beside)).collect())
}

/// Cuts triangles, of which each has so many records, into ranges whose sums take at most `room`, or that are one triangle.
fn split(records: &[u64], room: u64) -> Vec<Part> {
    let (mut parts, mut start, mut held) = (Vec::new(), 0, 0);
    for (at, &own) in records.iter().enumerate() {
        let at = at as u32;
        if at > start && sums(u64::from(at - start) + 1, held + own) > room {
            parts.push((start..at, sums(u64::from(at - start), held)));
            (start, held) = (at, 0);
        }
        held += own;
    }
    let end = records.len() as u32;
    parts.push((start..end, sums(u64::from(end - start), held)));
    parts
}

/// The maps of one shard out of all segments. The order of segments does not matter.
pub fn merge_shard<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32) -> Result<ShardMaps> {
    merge_part(segments, shard, 0..SHARD)
}

/// The maps of a part of it; further parts follow, unless it goes to the shard's end.
pub fn merge_part<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: u32, part: Range<u32>) -> Result<ShardMaps> {
    let mut all = vec![Sums::default(); part.len()];
    let first = shard * SHARD + part.start;
    for segment in segments {
        let Some(block) = segment.block(shard)? else { continue };
        let mut records = block.records.as_slice();
        for (triangle, frames, count) in block.triangles {
            let (own, rest) = records.split_at(count as usize);
            records = rest;
            let slot = triangle.checked_sub(first).and_then(|slot| all.get_mut(slot as usize));
            if let Some(sums) = slot {
                sums.add(frames, own);
            }
        }
    }
    let observed = all.into_iter().enumerate().filter(|(_, sums)| !sums.bins.is_empty());
    let triangles = observed.map(|(slot, mut sums)| {
        sums.settle();
        (first + slot as TriangleId, sums.frames, SparseMap { bins: sums.bins })
    });
    Ok(ShardMaps { shard, more: part.end < SHARD, triangles: triangles.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_few_cover_all_and_fit() {
        let records: Vec<u64> = (0..100).map(|i| i * 37 % 23).collect();
        let whole = sums(100, records.iter().sum());
        for room in [0, 1, sums(1, 22), 5_000, whole / 2, whole - 1, whole, u64::MAX] {
            let parts = split(&records, room);
            assert_eq!((parts[0].0.start, parts.last().map(|p| p.0.end)), (0, Some(100)));
            assert!(parts.windows(2).all(|two| two[0].0.end == two[1].0.start));
            for (range, held) in &parts {
                let own: u64 = records[range.start as usize..range.end as usize].iter().sum();
                assert_eq!(*held, sums(range.len() as u64, own));
                assert!(*held <= room || range.len() == 1, "{range:?} of {room}");
            }
            // Two neighbours would be too much for one.
            let own = |range: Range<u32>| records[range.start as usize..range.end as usize].iter().sum();
            let both = |two: &[Part]| sums(u64::from(two[1].0.end - two[0].0.start), own(two[0].0.start..two[1].0.end));
            assert!(parts.windows(2).all(|two| both(two) > room), "{room}: {parts:?}");
        }
        assert_eq!(split(&records, whole).len(), 1);
        // Empty maps take nothing, and full ones no more than they have bins.
        assert_eq!(split(&[0; 9], 0), [(0..9, 0)]);
        assert_eq!(sums(2, u64::from(u32::MAX)), 4 * 2 * FRONT_BINS as u64 * BIN);
    }
}
