//! Joins many small segments into few large ones. When memory is short, a unit writes a segment whenever its memory is full;
//! before the unit ends, these segments become one: the same one that the unit writes when memory is not short.

use std::io::{self, Write};

use super::collect::{TriangleMap, collect_shard};
use super::format::Entry;
use super::reader::Segment;
use super::writer::SegmentWriter;
use crate::base::ids::ShardId;
use crate::base::{Error, Result};

/// Segments that are joined at a time, at most: all are open, and read in turns.
pub(crate) const FAN_IN: usize = 16;

/// The positions of the segments to join next, given all sizes; none when one segment is left. The smallest go first, and
/// just so many that every later join has the full width: so the fewest bytes are written again (Huffman 1952, for wider
/// trees).
pub(crate) fn next(sizes: &[u64]) -> Vec<usize> {
    if sizes.len() < 2 {
        return Vec::new();
    }
    let mut order: Vec<usize> = (0..sizes.len()).collect();
    order.sort_by_key(|&at| sizes[at]);
    order.truncate((sizes.len() - 2) % (FAN_IN - 1) + 2);
    order
}

/// Writes the sum of segments as one segment. Holds one shard at a time. Gives back the sink and the new index; `failed`
/// turns an error of the sink into one that names the file.
pub(crate) fn join<B: AsRef<[u8]>, W: Write>(
    segments: &[Segment<B>],
    out: W,
    failed: impl Fn(io::Error) -> Error,
) -> Result<(W, Vec<Entry>)> {
    let mut shards: Vec<ShardId> =
        segments.iter().flat_map(|segment| segment.index().map(|entry| entry.shard)).collect();
    shards.sort_unstable();
    shards.dedup();
    let mut writer = SegmentWriter::new(out).map_err(&failed)?;
    for shard in shards {
        for TriangleMap { triangle, frames, cells } in collect_shard(segments, shard)?.triangles {
            writer.push(triangle, frames, &cells).map_err(&failed)?;
        }
    }
    writer.finish().map_err(failed)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Joins until one is left: the number of joins, the width of the widest, bytes written.
    fn joins(mut sizes: Vec<u64>) -> (usize, usize, u64) {
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
    fn joins_are_bounded_and_few() {
        assert_eq!(next(&[]), [0; 0]);
        assert_eq!(next(&[7]), [0; 0]);
        assert_eq!(next(&[9, 1, 5]), [1, 2, 0]);
        for n in 2..200 {
            let (count, widest, written) = joins(vec![1; n]);
            assert!(widest <= FAN_IN && count == (n - 1).div_ceil(FAN_IN - 1), "{n}: {count} joins, {widest} wide");
            let levels = (n as f64).log(FAN_IN as f64).ceil();
            assert!(written as f64 <= levels * n as f64, "{n}: {written} bytes");
        }
    }

    #[test]
    fn the_large_one_is_written_once() {
        let mut sizes = vec![1; 40];
        sizes[17] = 1000;
        assert!(joins(sizes).2 < 1000 + 3 * 40);
    }
}
