//! Ids are positions: of a triangle in the mesh file, of a frame in the list of frames sorted by name, of a shard along
//! the triangles. In memory and in files an id is its `u32`.

use std::fmt;
use std::ops::Range;

use bytemuck::{Pod, Zeroable};

use super::convert::to_u32;

/// A triangle's position in the mesh, counted from 0 in file order.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct TriangleId(pub u32);

/// A frame's position among the frames sorted by image name.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct FrameId(pub u32);

/// A shard's position along the mesh: shard 0 holds the first [`ShardId::TRIANGLES`] triangles.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash, Default, Pod, Zeroable)]
#[repr(transparent)]
pub struct ShardId(pub u32);

impl TriangleId {
    /// No triangle: the id in the hit of a ray that misses.
    pub const NONE: TriangleId = TriangleId(u32::MAX);

    /// The id of the triangle at a position in a list of all triangles.
    ///
    /// # Panics
    /// A position past 32 bits: no mesh has one.
    #[inline]
    pub fn at(index: usize) -> TriangleId {
        TriangleId(to_u32(index))
    }

    /// The ids of a mesh of `count` triangles, ascending.
    pub fn all(count: usize) -> impl DoubleEndedIterator<Item = TriangleId> + ExactSizeIterator + Clone {
        TriangleId::between(0..to_u32(count))
    }

    /// The ids of a range of positions, ascending.
    pub fn between(range: Range<u32>) -> impl DoubleEndedIterator<Item = TriangleId> + ExactSizeIterator + Clone {
        range.map(TriangleId)
    }

    /// The triangle's position in a list of all triangles.
    #[inline]
    pub const fn index(self) -> usize {
        self.0 as usize
    }

    /// The shard that holds the triangle.
    #[inline]
    pub const fn shard(self) -> ShardId {
        ShardId(self.0 / ShardId::TRIANGLES)
    }
}

impl FrameId {
    /// The id of the frame at a position in the list of all frames.
    ///
    /// # Panics
    /// A position past 32 bits: no scene has one.
    #[inline]
    pub fn at(index: usize) -> FrameId {
        FrameId(to_u32(index))
    }

    /// The ids of `count` frames, ascending.
    pub fn all(count: usize) -> impl DoubleEndedIterator<Item = FrameId> + ExactSizeIterator + Clone {
        (0..to_u32(count)).map(FrameId)
    }

    /// The frame's position in the list of all frames.
    #[inline]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl ShardId {
    /// Triangles in a shard.
    pub const TRIANGLES: u32 = 4096;

    /// The last shard that a triangle can be in.
    pub const LAST: ShardId = TriangleId::NONE.shard();

    /// The shards of a mesh of `count` triangles, ascending.
    pub fn all(count: usize) -> impl DoubleEndedIterator<Item = ShardId> + ExactSizeIterator + Clone {
        (0..to_u32(count.div_ceil(ShardId::TRIANGLES as usize))).map(ShardId)
    }

    /// The shard's first triangle.
    #[inline]
    pub const fn first(self) -> TriangleId {
        TriangleId(self.0 * ShardId::TRIANGLES)
    }

    /// The shard's position in a list of all shards.
    #[inline]
    pub const fn index(self) -> usize {
        self.0 as usize
    }
}

impl fmt::Display for TriangleId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for FrameId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

impl fmt::Display for ShardId {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.0.fmt(f)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shards_share_out_the_triangles() {
        assert_eq!([0, 4095, 4096, u32::MAX].map(|t| TriangleId(t).shard().0), [0, 0, 1, 1_048_575]);
        assert_eq!(ShardId::LAST.first().shard(), ShardId::LAST);
        assert_eq!([0, 1, 4096, 4097].map(|count| ShardId::all(count).len()), [0, 1, 1, 2]);
        assert!(TriangleId::all(9000).map(TriangleId::shard).is_sorted());
    }
}
