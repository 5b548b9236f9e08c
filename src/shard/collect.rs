//! Collects a shard: merges its blocks from any number of segments into the maps of its triangles.
//!
//! Blocks are added up one by one, so that memory grows with the filled bins of the maps and not with the number of
//! segments. A shard that does not fit into memory is collected in slices, each a range of its triangles. The blocks are
//! decoded again for each slice; a block is always decoded as a whole.

use std::ops::Range;

use super::reader::Segment;
use super::sum::sum_by_key;
use crate::base::Result;
use crate::base::convert::to_u32;
use crate::base::ids::{ShardId, TriangleId};
use crate::scene::cells::CELLS;
use crate::scene::reflectance::{Bin, BinSum};

/// The map of one triangle.
#[derive(Debug, Clone, PartialEq)]
pub struct TriangleMap {
    /// The triangle.
    pub triangle: TriangleId,
    /// Frames that saw the triangle.
    pub frames: u32,
    /// The sums of the triangle's cells (`scene::cells`), ascending.
    pub cells: Vec<(Bin, BinSum)>,
}

/// The maps of the observed triangles in a shard, or in a slice of one.
#[derive(Debug, Default, PartialEq)]
pub struct ShardMaps {
    /// The shard.
    pub shard: ShardId,
    /// Whether further slices of the shard follow.
    pub more: bool,
    /// The maps, ascending by triangle.
    pub triangles: Vec<TriangleMap>,
}

/// The sums of one triangle so far.
#[derive(Debug, Clone, Default)]
struct Sums {
    frames: u32,
    bins: Vec<(Bin, BinSum)>,
    /// Number of bins that are summed and distinct; the bins after them still have to be added up.
    distinct: usize,
}

impl Sums {
    fn add(&mut self, frames: u32, bins: &[(Bin, BinSum)]) {
        self.frames = self.frames.saturating_add(frames);
        if self.bins.len() + bins.len() > 2 * self.distinct + 16 {
            self.settle();
        }
        self.bins.extend_from_slice(bins);
    }

    /// Adds up the sums of equal bins.
    fn settle(&mut self) {
        sum_by_key(&mut self.bins, |bin| bin.0, |kept, next| kept.1.add(&next.1));
        self.distinct = self.bins.len();
    }
}

/// Bytes of a bin's sums.
const BIN: u64 = size_of::<(Bin, BinSum)>() as u64;

/// Bytes that the sums of so many triangles take at most: all of their records, or as many as their maps have bins.
fn sums(triangles: u64, records: u64) -> u64 {
    // Twice as many are held before they are added up, and vectors may be half full.
    (2 * records).min(4 * triangles * CELLS as u64) * BIN
}

/// Bytes that collecting holds beside the sums: one decoded block, and a place for every triangle.
fn beside<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: ShardId) -> u64 {
    let widest = segments.iter().filter_map(|s| s.entry(shard)).map(|e| u64::from(e.records)).max().unwrap_or(0);
    widest * (2 * BIN + 72) + u64::from(ShardId::TRIANGLES) * (size_of::<Sums>() + size_of::<u64>()) as u64
}

/// Bytes that [`collect_shard`] holds at most.
pub(crate) fn collect_need<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: ShardId) -> u64 {
    let records = segments.iter().filter_map(|s| s.entry(shard)).map(|e| u64::from(e.records)).sum();
    sums(u64::from(ShardId::TRIANGLES), records) + beside(segments, shard)
}

/// Bytes that collecting the same shard triangle by triangle holds at most: the shard cannot be collected with less.
pub(crate) fn collect_least<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: ShardId) -> u64 {
    let blocks = segments.iter().filter(|s| s.entry(shard).is_some()).count() as u64;
    collect_need(segments, shard).min(sums(1, blocks * CELLS as u64) + beside(segments, shard))
}

/// A range of a shard's triangles that is collected alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Slice {
    /// The triangles, counted from the shard's first.
    pub triangles: Range<u32>,
    /// Bytes that collecting the slice holds at most.
    pub need: u64,
}

impl Slice {
    /// The slice that is a whole shard, which needs so many bytes.
    pub(crate) fn whole(need: u64) -> Slice {
        Slice { triangles: 0..ShardId::TRIANGLES, need }
    }
}

/// Cuts a shard into as few slices as possible, so that each needs at most `most` bytes or is a single triangle. Decodes all
/// blocks of the shard, one after the other.
pub(crate) fn collect_slices<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: ShardId, most: u64) -> Result<Vec<Slice>> {
    let mut records = vec![0u64; ShardId::TRIANGLES as usize];
    for segment in segments {
        for seen in segment.block(shard)?.into_iter().flat_map(|block| block.triangles) {
            records[seen.triangle.index() - shard.first().index()] += u64::from(seen.records);
        }
    }
    let beside = beside(segments, shard);
    let mut slices = split(&records, most.saturating_sub(beside));
    slices.iter_mut().for_each(|slice| slice.need += beside);
    Ok(slices)
}

/// Cuts triangles, given the number of records of each, into slices whose sums take at most `most` bytes or that are a
/// single triangle.
fn split(records: &[u64], most: u64) -> Vec<Slice> {
    let slice = |triangles: Range<u32>, records| {
        let need = sums(u64::from(triangles.end - triangles.start), records);
        Slice { triangles, need }
    };
    let (mut slices, mut start, mut held) = (Vec::new(), 0, 0);
    for (at, &own) in (0u32..).zip(records) {
        if at > start && sums(u64::from(at - start) + 1, held + own) > most {
            slices.push(slice(start..at, held));
            (start, held) = (at, 0);
        }
        held += own;
    }
    slices.push(slice(start..to_u32(records.len()), held));
    slices
}

/// Collects the maps of one shard from all segments. The order of the segments does not matter.
pub fn collect_shard<B: AsRef<[u8]>>(segments: &[Segment<B>], shard: ShardId) -> Result<ShardMaps> {
    collect_slice(segments, shard, 0..ShardId::TRIANGLES)
}

/// Collects the maps of a slice: the triangles of this range, counted from the shard's first.
pub(crate) fn collect_slice<B: AsRef<[u8]>>(
    segments: &[Segment<B>],
    shard: ShardId,
    slice: Range<u32>,
) -> Result<ShardMaps> {
    let mut all = vec![Sums::default(); slice.len()];
    let first = shard.first().0 + slice.start;
    for segment in segments {
        let Some(block) = segment.block(shard)? else { continue };
        let mut records = block.records.as_slice();
        for seen in block.triangles {
            let (own, rest) = records.split_at(seen.records as usize);
            records = rest;
            let slot = seen.triangle.0.checked_sub(first).and_then(|slot| all.get_mut(slot as usize));
            if let Some(sums) = slot {
                sums.add(seen.frames, own);
            }
        }
    }
    let observed = all.into_iter().enumerate().filter(|(_, sums)| !sums.bins.is_empty());
    let triangles = observed.map(|(slot, mut sums)| {
        sums.settle();
        TriangleMap { triangle: TriangleId(first + to_u32(slot)), frames: sums.frames, cells: sums.bins }
    });
    Ok(ShardMaps { shard, more: slice.end < ShardId::TRIANGLES, triangles: triangles.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn slices_are_few_cover_all_and_fit() {
        let records: Vec<u64> = (0..100).map(|i| i * 37 % 23).collect();
        let own = |range: &Range<u32>| records[range.start as usize..range.end as usize].iter().sum::<u64>();
        let whole = sums(100, records.iter().sum());
        for most in [0, 1, sums(1, 22), 5_000, whole / 2, whole - 1, whole, u64::MAX] {
            let slices = split(&records, most);
            assert_eq!((slices[0].triangles.start, slices.last().map(|s| s.triangles.end)), (0, Some(100)));
            assert!(slices.windows(2).all(|two| two[0].triangles.end == two[1].triangles.start));
            for Slice { triangles, need } in &slices {
                assert_eq!(*need, sums(triangles.len() as u64, own(triangles)));
                assert!(*need <= most || triangles.len() == 1, "{triangles:?} of {most}");
            }
            // Two neighbours would be too much for one.
            let both = |two: &[Slice]| {
                let length = u64::from(two[1].triangles.end - two[0].triangles.start);
                sums(length, own(&two[0].triangles) + own(&two[1].triangles))
            };
            assert!(slices.windows(2).all(|two| both(two) > most), "{most}: {slices:?}");
        }
        assert_eq!(split(&records, whole).len(), 1);
        // Empty maps take nothing, and full ones no more than they have bins.
        assert_eq!(split(&[0; 9], 0), [Slice { triangles: 0..9, need: 0 }]);
        assert_eq!(sums(2, u64::from(u32::MAX)), 4 * 2 * CELLS as u64 * BIN);
    }
}
