//! Intrinsics: pixel to ray and back. The centre of the first pixel is (0.5, 0.5).

use glam::{DVec2, DVec3};

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

/// Lens models, as COLMAP defines and names them.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Model {
    /// No distortion: focal lengths and principal point, pixels.
    Pinhole {
        /// Focal lengths.
        f: DVec2,
        /// Principal point.
        c: DVec2,
    },
}

impl Camera {
    /// The unit direction, in camera coordinates, of what is seen at `pixel`; `None` where the lens sees nothing there.
    pub fn ray(&self, pixel: DVec2) -> Option<DVec3> {
        match self.model {
            Model::Pinhole { f, c } => Some(((pixel - c) / f).extend(1.0).normalize()),
        }
    }

    /// Where a point in camera coordinates is seen; `None` if the lens cannot see it.
    pub fn project(&self, point: DVec3) -> Option<DVec2> {
        match self.model {
            Model::Pinhole { f, c } => (point.z > 0.0).then(|| f * point.truncate() / point.z + c),
        }
    }
}
