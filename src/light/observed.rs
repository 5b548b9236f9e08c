//! What the photographs show of sampled triangles.

use bytemuck::{Pod, Zeroable};

/// What one frame saw of one sampled triangle: 32 bytes, plain old data.
#[derive(Debug, Clone, Copy, PartialEq, Pod, Zeroable)]
#[repr(C)]
pub struct Sighting {
    /// The frame's position in the list of frames.
    pub frame: u32,
    /// The triangle's position in the sample.
    pub sample: u32,
    /// Pixels of the triangle that are not masked, clipped ones included, away from silhouettes.
    pub pixels: u32,
    /// Clipped pixels among them.
    pub clipped: u32,
    /// Mean of the pixels, linear RGB, as photographed: no gain is applied.
    pub mean: [f32; 3],
    /// Squared distance of the pixels from the image's centre, on average; 1 at the corners.
    pub radius2: f32,
}

impl Sighting {
    /// The luminance of the mean.
    pub(super) fn luma(&self) -> f32 {
        luma(self.mean)
    }
}

/// The luminance of linear sRGB.
pub(crate) fn luma(rgb: [f32; 3]) -> f32 {
    0.2126 * rgb[0] + 0.7152 * rgb[1] + 0.0722 * rgb[2]
}
