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

impl Model {
    /// The name that COLMAP gives a model's number, and how many parameters it has.
    pub fn colmap_name(id: i32) -> Result<(&'static str, usize), String> {
        match id {
            0 => Ok(("SIMPLE_PINHOLE", 3)),
            1 => Ok(("PINHOLE", 4)),
            _ => Err(format!("camera model {id} is not known")),
        }
    }

    /// COLMAP's number, name and parameters.
    pub fn to_colmap(&self) -> (i32, &'static str, Vec<f64>) {
        match self {
            Model::Pinhole { f, c } => (1, "PINHOLE", vec![f.x, f.y, c.x, c.y]),
        }
    }
}

impl Camera {
    /// A camera as COLMAP writes it, or what is wrong with it.
    pub fn from_colmap(name: &str, width: u64, height: u64, parameters: &[f64]) -> Result<Camera, String> {
        let (f, c) = match (name, parameters) {
            ("SIMPLE_PINHOLE", &[f, x, y]) => (DVec2::splat(f), DVec2::new(x, y)),
            ("PINHOLE", &[fx, fy, x, y]) => (DVec2::new(fx, fy), DVec2::new(x, y)),
            ("SIMPLE_PINHOLE" | "PINHOLE", _) => return Err(format!("{} parameters for {name}", parameters.len())),
            _ => return Err(format!("camera model {name} is not known")),
        };
        let size = |v: u64| u32::try_from(v).ok().filter(|v| (1..1_000_000).contains(v));
        let (Some(width), Some(height)) = (size(width), size(height)) else {
            return Err(format!("{width} x {height} pixels: 1 to 999999 each are allowed"));
        };
        if !(f.is_finite() && c.is_finite() && f.min_element() > 0.0) {
            return Err(format!("its parameters are {parameters:?}: finite ones are needed, focal lengths above 0"));
        }
        Ok(Camera { width, height, model: Model::Pinhole { f, c } })
    }

    /// The camera of the same lens with an image `by` times smaller each way.
    pub fn down_scaled(&self, by: u32) -> Camera {
        let (width, height) = (self.width / by.max(1), self.height / by.max(1));
        let scale = DVec2::new(f64::from(width) / f64::from(self.width), f64::from(height) / f64::from(self.height));
        let Model::Pinhole { f, c } = self.model;
        Camera { width, height, model: Model::Pinhole { f: f * scale, c: c * scale } }
    }

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
