//! Few large segments instead of many small ones. When memory is short a unit writes a segment whenever it is full; before
//! the unit ends they become one, which is also the one that it would have written with memory to spare.

use std::io::{self, Write};

use super::format::Entry;
use super::merge::merge_shard;
use super::reader::Segment;
use super::writer::SegmentWriter;
use crate::base::{Error, Result};

/// Segments that are merged at once, at most: what is held open, and read in turns.
pub const FAN_IN: usize = 16;

/// Which segments of these sizes are to be merged next, as positions; none when one is left. The smallest go first, and just
/// so many that every later merge is as wide as it may be: so the fewest bytes are written again (Huffman 1952, for wider
/// trees).
pub fn next(sizes: &[u64]) -> Vec<usize> {
    if sizes.len() < 2 {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&at| sizes[at]);
    order.truncate((sizes.len() - 2) % (FAN_IN - 1) + 2);
    order
}

/// Writes the sum of segments as one. Holds one shard at a time. Gives the sink back and the new index; `failed` makes an
/// error of one of the sink's.
pub fn merge<B: AsRef<[u8]>, W: Write>(
    segments: &[Segment<B>],
    out: W,
    failed: impl Fn(io::Error) -> Error,
) -> Result<(W, Vec<Entry>)> {
    let mut shards: Vec<u32> = segments.iter().flat_map(|segment| segment.index().map(|entry| entry.shard)).collect();
    shards.sort_unstable();
    shards.dedup();
    let mut writer = SegmentWriter::new(out).map_err(&failed)?;
    for shard in shards {
        for (triangle, frames, map) in merge_shard(segments, shard)?.triangles {
            writer.push(triangle, frames, &map.bins).map_err(&failed)?;
        }
    }
    writer.finish().map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Merges until one is left: how many merges, how wide the widest was, bytes written.
    fn merges(mut sizes: Vec<u64>) -> (usize, usize, u64) {
        let (mut count, mut widest, mut written) = (0, 0, 0);
        loop {
            let mut picked = next(&sizes);
            if picked.is_empty() {
                assert_eq!(sizes.len(), 1);
                return (count, widest, written);
            }
            let sum: u64 = picked.iter().map(|&at| sizes[at]).sum();
            (count, widest, written) = (count + 1, widest.max(picked.len()), written + sum);
            picked.sort_unstable();
            picked.iter().rev().for_each(|&at| {
                sizes.remove(at);
            });
            sizes.push(sum);
        }
    }

    #[test]
    fn merges_are_bounded_and_few() {
        assert_eq!(next(&[]), [0; 0]);
        assert_eq!(next(&[7]), [0; 0]);
        assert_eq!(next(&[9, 1, 5]), [1, 2, 0]);
        for n in 2..200 {
            let (count, widest, written) = merges(vec![1; n]);
            assert!(widest <= FAN_IN && count == (n - 1).div_ceil(FAN_IN - 1), "{n}: {count} merges, {widest} wide");
            let levels = (n as f64).log(FAN_IN as f64).ceil();
            assert!(written as f64 <= levels * n as f64, "{n}: {written} bytes");
        }
    }

    #[test]
    fn the_large_one_is_written_once() {
        let mut sizes = vec![1; 40];
        sizes[17] = 1000;
        assert!(merges(sizes).2 < 1000 + 3 * 40);
    }
}
