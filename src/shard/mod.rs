//! Observations out of core: the segment format, its writer and reader, how a shard is collected from many segments, and
//! the rows of a shard.
//!
//! A *segment* is what a group of frames saw: an immutable file of records sorted by (triangle, bin). A *shard* is
//! 4,096 neighbouring triangles ([`ShardId`](crate::base::ids::ShardId)). Every segment keeps each shard in a block of its
//! own, so that the reduce side takes shard after shard from any number of segments and never holds more than one shard of
//! them, or a slice of one. The rows inferred of a shard are a file of their own ([`rows`]), which stays valid until one of
//! the shard's blocks changes.
//!
//! Sums are integers: adding them is exact, and the result is the same bits in whatever order they are added.

pub(crate) mod accumulate;
pub(crate) mod block;
pub(crate) mod blocks;
pub(crate) mod collect;
pub(crate) mod compact;
pub(crate) mod format;
pub(crate) mod reader;
pub(crate) mod rows;
mod sum;
mod varint;
pub(crate) mod writer;

#[cfg(test)]
mod tests;

pub(crate) use accumulate::{Accumulator, FrameRecords, GroupRecords, Record};
pub use blocks::Blocks;
pub use collect::collect_shard;
pub(crate) use collect::{ShardMaps, TriangleMap};
pub(crate) use collect::{Slice, collect_least, collect_need, collect_slice, collect_slices};
pub use reader::Segment;
pub(crate) use rows::Row;
pub use rows::ShardRows;
