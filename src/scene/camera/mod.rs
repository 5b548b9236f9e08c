//! Intrinsics: pixel to ray and back. The centre of the first pixel is (0.5, 0.5); camera axes are x right, y down,
//! z forward.
//!
//! A lens takes a direction to a plane in one of two ways, (x, y) / z or the angle to the axis times the direction of
//! (x, y) (equidistant), and moves points on that plane (`distortion`). Focal lengths and principal point give pixels.
//! Back from a pixel the distortion is inverted by Newton's method (`inverse`): exact to rounding, or no ray at all where
//! the lens folds and a pixel has no direction of its own.

mod colmap;
mod distortion;
mod inverse;
#[cfg(test)]
mod tests;

use glam::{DVec2, DVec3};

use inverse::Inverse;

/// A camera without its place: image size and lens.
#[derive(Debug, Clone, PartialEq)]
pub struct Camera {
    /// Columns, pixels.
    pub width: u32,
    /// Rows, pixels.
    pub height: u32,
    /// Lens model and its parameters.
    pub model: Model,
}

/// A lens: focal lengths, principal point, and how it distorts.
#[derive(Debug, Clone, PartialEq)]
pub struct Model {
    /// COLMAP's number of the model.
    id: i32,
    /// As COLMAP orders them.
    parameters: Vec<f64>,
    /// Focal lengths, pixels.
    f: DVec2,
    /// Principal point, pixels.
    c: DVec2,
    lens: Lens,
}

/// How directions become points on the plane of unit focal length.
#[derive(Debug, Clone, PartialEq)]
enum Lens {
    /// (x, y) / z.
    Pinhole,
    /// (x, y) / z, moved.
    Perspective(Inverse),
    /// The angle to the axis along (x, y), moved.
    Equidistant(Inverse),
    /// Devernay and Faugeras' field-of-view model (2001), by its angle omega.
    FieldOfView(f64),
}

impl Model {
    /// A lens without distortion, of focal lengths `f` and principal point `c`, pixels.
    pub fn pinhole(f: DVec2, c: DVec2) -> Model {
        Model { id: 1, parameters: vec![f.x, f.y, c.x, c.y], f, c, lens: Lens::Pinhole }
    }

    fn scaled(&self, scale: DVec2) -> Model {
        let (f, c) = (self.f * scale, self.c * scale);
        let mut parameters = self.parameters.clone();
        match colmap::focal_lengths(self.id) {
            1 => parameters[..3].copy_from_slice(&[f.x, c.x, c.y]),
            _ => parameters[..4].copy_from_slice(&[f.x, f.y, c.x, c.y]),
        }
        Model { id: self.id, parameters, f, c, lens: self.lens.clone() }
    }
}

impl Camera {
    /// The camera of the same lens with an image `by` times smaller each way. Sides that `by` does not divide lose the
    /// rest, and pixels are then a little more than `by` times larger.
    pub fn down_scaled(&self, by: u32) -> Camera {
        let (width, height) = (self.width / by.max(1), self.height / by.max(1));
        let scale = DVec2::new(f64::from(width) / f64::from(self.width), f64::from(height) / f64::from(self.height));
        Camera { width, height, model: self.model.scaled(scale) }
    }

    /// The unit direction, in camera coordinates, of what is seen at `pixel`; `None` where the lens sees nothing there.
    #[inline]
    pub fn ray(&self, pixel: DVec2) -> Option<DVec3> {
        let m = &self.model;
        let at = (pixel - m.c) / m.f;
        match &m.lens {
            Lens::Pinhole => Some(at.extend(1.0).normalize()),
            Lens::Perspective(lens) => lens.undo(at).map(|q| q.extend(1.0).normalize()),
            Lens::Equidistant(lens) => lens.undo(at).map(|q| {
                let angle = q.length();
                let (sin, cos) = angle.sin_cos();
                let across = if angle > 0.0 { q * (sin / angle) } else { DVec2::ZERO };
                across.extend(cos)
            }),
            Lens::FieldOfView(omega) => distortion::undo_field_of_view(*omega, at).map(|q| q.extend(1.0).normalize()),
        }
    }

    /// Where a point in camera coordinates is seen, pixels, inside the image or not; `None` if the lens cannot see it.
    #[inline]
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        let m = &self.model;
        let flat = || (point.z > 0.0).then(|| point.truncate() / point.z);
        let moved = match &m.lens {
            Lens::Pinhole => flat(),
            Lens::Perspective(lens) => flat().and_then(|q| lens.apply(q)),
            Lens::Equidistant(lens) => {
                let (across, length) = (point.truncate(), point.truncate().length());
                let angle = length.atan2(point.z);
                // Straight behind, no direction is the right one.
                let seen = length > 0.0 || point.z > 0.0;
                seen.then(|| if length > 0.0 { across * (angle / length) } else { DVec2::ZERO })
                    .and_then(|q| lens.apply(q))
            }
            Lens::FieldOfView(omega) => flat().map(|q| distortion::field_of_view(*omega, q)),
        };
        moved.map(|at| m.f * at + m.c)
    }
}
