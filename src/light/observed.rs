//! What one frame saw of one triangle.

use bytemuck::{Pod, Zeroable};

/// What one frame saw of one of the triangles that were looked at.
#[derive(Debug, Clone, Copy, PartialEq, Default, Pod, Zeroable)]
#[repr(C)]
pub(crate) struct Sighting {
    /// The frame.
    pub frame: u32,
    /// The triangle, by its position among those that were looked at.
    pub sample: u32,
    /// Pixels of the triangle that are not masked, clipped ones included, away from silhouettes.
    pub pixels: u32,
    /// Clipped pixels among them.
    pub clipped: u32,
    /// Mean linear radiance of the pixels, before any gain.
    pub mean: [f32; 3],
    /// Squared distance of the pixels from the picture's middle, in half diagonals.
    pub radius2: f32,
}
