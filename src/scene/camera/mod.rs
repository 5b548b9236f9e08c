//! Intrinsics: from a pixel to its ray and back. The centre of the first pixel is (0.5, 0.5). Camera axes are x right,
//! y down, z forward.
//!
//! A [`Lens`] projects a direction to a plane (`lens`), moves the point on that plane (`distortion`), and scales it to
//! pixels. On the way back, Newton's method undoes the distortion within its reach (`reach`): the ray is exact to
//! rounding, and a pixel beyond the fold of a lens has no ray.

mod distortion;
mod lens;
mod reach;
#[cfg(test)]
mod tests;
mod unified;

use glam::{DVec2, DVec3};

pub(crate) use distortion::Distortion;
pub use lens::Lens;
pub(crate) use lens::Projection;
pub(crate) use unified::Unified;

/// The most pixels along a side of an image.
const LONGEST: u64 = 999_999;

/// A camera without its pose: the size of its images, and its lens.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Columns, pixels.
    pub width: u32,
    /// Rows, pixels.
    pub height: u32,
    /// The lens.
    pub lens: Lens,
}

impl Camera {
    /// A camera whose size a file gives.
    ///
    /// # Errors
    /// In words: a side of no pixels, or of more than 999,999.
    pub fn new(width: u64, height: u64, lens: Lens) -> Result<Camera, String> {
        let side = |pixels: u64| u32::try_from(pixels).ok().filter(|_| (1..=LONGEST).contains(&pixels));
        match (side(width), side(height)) {
            (Some(width), Some(height)) => Ok(Camera { width, height, lens }),
            _ => Err(format!("the image has {width} x {height} pixels; 1 to {LONGEST} a side are allowed")),
        }
    }

    /// The same camera with images `by` times smaller along each side. A side that `by` does not divide loses its last
    /// pixels; the other pixels are then a little more than `by` times larger.
    pub fn down_scaled(&self, by: u32) -> Camera {
        self.resized(self.width / by.max(1), self.height / by.max(1))
    }

    /// The same camera with images of this size, each side scaled on its own.
    pub fn resized(&self, width: u32, height: u32) -> Camera {
        let scale = DVec2::new(f64::from(width) / f64::from(self.width), f64::from(height) / f64::from(self.height));
        Camera { width, height, lens: self.lens.scaled(scale) }
    }

    /// The unit direction, in camera coordinates, that is seen at `pixel`; `None` where the lens sees nothing.
    #[inline]
    pub fn ray(&self, pixel: DVec2) -> Option<DVec3> {
        self.lens.ray(pixel)
    }

    /// The pixel, inside the image or not, where a point in camera coordinates is seen; `None` if the lens cannot see
    /// the point.
    #[inline]
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        self.lens.project(point)
    }
}
