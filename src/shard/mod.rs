//! Observations out of core: the segment format, its writer, its reader, the merge of many segments, and what comes
//! of a shard.
//!
//! A *segment* is what a group of frames saw: an immutable file of records sorted by (triangle, bin). A *shard* is a
//! range of [`SHARD`](format::SHARD) triangles. Every segment keeps each shard in a block of its own, so that the reduce
//! side takes shard after shard from any number of segments and never holds more than one shard of them, or a part of one. What it finds
//! out about a shard is a file of its own ([`rows`]), which stays good until one of the shard's blocks changes.
//!
//! Sums are integers: merging is exact, and its result the same bits whatever was merged in what order.

pub mod accumulate;
pub mod block;
pub mod blocks;
pub mod compact;
pub mod format;
pub mod merge;
pub mod reader;
pub mod rows;
mod varint;
pub mod writer;

#[cfg(test)]
mod tests;

pub use accumulate::{Accumulator, FrameRows, GroupRows, Record};
pub use blocks::Blocks;
pub use merge::{ShardMaps, merge_least, merge_need, merge_part, merge_parts, merge_shard};
pub use reader::Segment;
pub use rows::ShardRows;
pub use writer::SegmentWriter;
