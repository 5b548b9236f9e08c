//! Ids are positions: of a triangle in the mesh file, of a frame in the list of frames sorted by name.

/// A triangle's position in the mesh, counted from 0 in file order.
pub type TriangleId = u32;

/// No triangle: what a ray that misses carries.
pub const NO_TRIANGLE: TriangleId = u32::MAX;

/// A frame's position among the frames sorted by image name.
pub type FrameId = u32;
