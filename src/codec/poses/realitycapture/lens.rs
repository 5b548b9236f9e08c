//! A lens of RealityCapture: a focal length of a sensor 36 mm wide, and its principal point from the image's centre.

use glam::DVec2;

use crate::codec::images::Size;
use crate::scene::camera::{Camera, Lens, Projection};

/// The width of the sensor, millimetres.
const FULL_FRAME: f64 = 36.0;

/// The camera of an image.
///
/// # Errors
/// In words: a parameter out of range.
pub(super) fn camera(
    Size { width, height }: Size,
    focal: f64,
    point: DVec2,
    projection: Projection,
) -> Result<Camera, String> {
    let size = DVec2::new(width.into(), height.into());
    let unit = size.max_element();
    let lens = Lens::new(DVec2::splat(focal / FULL_FRAME * unit), size * 0.5 + point * unit, projection)?;
    Camera::new(width.into(), height.into(), lens)
}
