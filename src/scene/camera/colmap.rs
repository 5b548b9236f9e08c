//! COLMAP's camera models: names, numbers, parameters (`src/colmap/sensor/models.h` of COLMAP).

use std::f64::consts::PI;

use glam::DVec2;

use super::distortion::Polynomial;
use super::inverse::Inverse;
use super::{Camera, Lens, Model};

/// Name, number of focal lengths, number of parameters. The position is COLMAP's number of the model.
const MODELS: [(&str, usize, usize); 12] = [
    ("SIMPLE_PINHOLE", 1, 3),
    ("PINHOLE", 2, 4),
    ("SIMPLE_RADIAL", 1, 4),
    ("RADIAL", 1, 5),
    ("OPENCV", 2, 8),
    ("OPENCV_FISHEYE", 2, 8),
    ("FULL_OPENCV", 2, 12),
    ("FOV", 2, 5),
    ("SIMPLE_RADIAL_FISHEYE", 1, 4),
    ("RADIAL_FISHEYE", 1, 5),
    ("THIN_PRISM_FISHEYE", 2, 12),
    ("RAD_TAN_THIN_PRISM_FISHEYE", 2, 16),
];

/// The most pixels along a side.
const LONGEST: u64 = 999_999;

/// The largest parameter: beyond, rays overflow.
const LARGEST: f64 = 1e9;

/// The farthest that a perspective lens sees: 89.99 degrees off its axis.
const FARTHEST: f64 = 5729.6;

/// How many focal lengths a model has, 1 or 2.
pub fn focal_lengths(id: i32) -> usize {
    usize::try_from(id).ok().and_then(|id| MODELS.get(id)).map_or(2, |m| m.1)
}

fn known() -> String {
    MODELS.map(|m| m.0).join(", ")
}

impl Model {
    /// The name that COLMAP gives a model's number, and how many parameters it has.
    ///
    /// # Errors
    /// The number is of no model that is known here.
    pub fn colmap_name(id: i32) -> Result<(&'static str, usize), String> {
        let found = usize::try_from(id).ok().and_then(|id| MODELS.get(id));
        found.map(|m| (m.0, m.2)).ok_or_else(|| format!("camera model {id} is not known; 0 to 11 are: {}", known()))
    }

    /// COLMAP's number, name and parameters.
    pub fn to_colmap(&self) -> (i32, &'static str, &[f64]) {
        let name = Model::colmap_name(self.id).map_or("", |m| m.0);
        (self.id, name, &self.parameters)
    }

    /// A lens by COLMAP's name of its model.
    fn from_colmap(name: &str, parameters: &[f64]) -> Result<Model, String> {
        let Some(id) = MODELS.iter().position(|m| m.0 == name) else {
            return Err(format!("camera model {name} is not known; these are: {}", known()));
        };
        let (_, focal_lengths, count) = MODELS[id];
        if parameters.len() != count {
            return Err(format!("{} parameters, and {name} has {count}", parameters.len()));
        }
        if let Some(bad) = parameters.iter().find(|p| p.is_nan() || p.abs() > LARGEST) {
            return Err(format!("a parameter is {bad}: finite numbers are needed, at most {LARGEST:e}"));
        }
        let (focal, rest) = parameters.split_at(focal_lengths);
        let (f, c) = (DVec2::new(focal[0], focal[focal_lengths - 1]), DVec2::new(rest[0], rest[1]));
        if f.min_element() <= 0.0 {
            return Err(format!("a focal length of {}: it must be above 0", f.min_element()));
        }
        Ok(Model { id: id as i32, parameters: parameters.to_vec(), f, c, lens: lens(name, &rest[2..])? })
    }
}

/// The lens of a model from its parameters after the principal point; as many as it has.
fn lens(name: &str, k: &[f64]) -> Result<Lens, String> {
    let numerator = |k: &[f64]| std::array::from_fn(|i| k.get(i).copied().unwrap_or(0.0));
    let perspective = |p| Lens::Perspective(Inverse::new(p, FARTHEST));
    let equidistant = |p| Lens::Equidistant(Inverse::new(p, PI));
    Ok(match name {
        "SIMPLE_RADIAL" | "RADIAL" => perspective(Polynomial { numerator: numerator(k), ..Polynomial::default() }),
        "OPENCV" | "FULL_OPENCV" => {
            let beyond = |i| k.get(i).copied().unwrap_or(0.0);
            perspective(Polynomial {
                numerator: numerator(&[k[0], k[1], beyond(4)]),
                denominator: [5, 6, 7].map(beyond),
                tangential: [k[2], k[3]],
                ..Polynomial::default()
            })
        }
        "FOV" if !(0.0..PI).contains(&k[0]) => {
            return Err(format!("omega is {}: it must lie in 0 to pi, below pi", k[0]));
        }
        "FOV" => Lens::FieldOfView(k[0]),
        "SIMPLE_RADIAL_FISHEYE" | "RADIAL_FISHEYE" | "OPENCV_FISHEYE" => {
            equidistant(Polynomial { numerator: numerator(k), ..Polynomial::default() })
        }
        "THIN_PRISM_FISHEYE" => equidistant(Polynomial {
            numerator: numerator(&[k[0], k[1], k[4], k[5]]),
            tangential: [k[2], k[3]],
            prism: [k[6], 0.0, k[7], 0.0],
            ..Polynomial::default()
        }),
        "RAD_TAN_THIN_PRISM_FISHEYE" => equidistant(Polynomial {
            numerator: numerator(&k[..6]),
            // Its first is the other's second.
            tangential: [k[7], k[6]],
            prism: [k[8], k[9], k[10], k[11]],
            chained: true,
            ..Polynomial::default()
        }),
        _ => Lens::Pinhole,
    })
}

impl Camera {
    /// A camera as COLMAP writes it: the model's name, the image's size, the parameters in COLMAP's order.
    ///
    /// # Errors
    /// What is wrong with it: an unknown model, a size or a parameter out of range, too few or too many parameters.
    pub fn from_colmap(name: &str, width: u64, height: u64, parameters: &[f64]) -> Result<Camera, String> {
        let size = |v: u64| u32::try_from(v).ok().filter(|_| (1..=LONGEST).contains(&v));
        let (Some(width), Some(height)) = (size(width), size(height)) else {
            return Err(format!("{width} x {height} pixels: 1 to {LONGEST} each are allowed"));
        };
        Ok(Camera { width, height, model: Model::from_colmap(name, parameters)? })
    }
}
