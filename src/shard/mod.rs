//! Observations out of core: the segment format, its writer, its reader, and the merge of many segments.
//!
//! A *segment* is what a group of frames saw: an immutable file of records sorted by (triangle, bin). A *shard* is a
//! range of [`SHARD`](format::SHARD) triangles. Every segment keeps each shard in a block of its own, so that the reduce
//! side takes shard after shard from any number of segments and never holds more than one shard of them.
//!
//! Sums are integers: merging is exact, and its result the same bits whatever was merged in what order.

pub mod accumulate;
pub mod block;
pub mod format;
pub mod merge;
pub mod reader;
mod varint;
pub mod writer;

#[cfg(test)]
mod tests;

pub use accumulate::{Accumulator, FrameRows, GroupRows, Record};
pub use merge::{ShardMaps, merge_shard};
pub use reader::Segment;
pub use writer::SegmentWriter;
