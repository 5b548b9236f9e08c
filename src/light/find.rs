//! Which light the frames were taken in.

use glam::Vec3;

use super::gains::Gains;
use super::observed::Sighting;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::trace::Bvh;

/// What the user says of the light.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Settings {
    /// What a white surface that faces the sun is in the photographs.
    pub white: Option<f64>,
}

/// The scene that the light falls on.
pub(crate) struct Scene<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Its hierarchy.
    pub bvh: &'a Bvh,
    /// The way up.
    pub up: Vec3,
    /// The frames' centres of projection.
    pub centres: &'a [Vec3],
}

/// How sure the light is.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Spread {
    /// Of the sun, degrees.
    pub sun_degrees: f32,
    /// Of the logarithm of sky over sun.
    pub ratio: [f32; 3],
    /// Of the logarithm of the scale.
    pub scale: f32,
}

/// What was decided.
#[derive(Debug, Clone, PartialEq)]
pub(crate) enum Decision {
    /// There is a sun.
    Sun,
    /// There is none.
    NoSun,
    /// It cannot be told.
    Doubtful,
}

/// The light that was found.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Found {
    /// Towards the sun.
    pub sun: Option<[f64; 3]>,
    /// The sun's colour.
    pub color: [f32; 3],
    /// The sky's radiance.
    pub sky: [f32; 3],
    /// How sure it is.
    pub spread: Spread,
    /// The rise of the cost where the sun is turned.
    pub turned: f32,
    /// White in the photographs.
    pub white: f32,
    /// What was decided.
    pub decided: Decision,
    /// In words.
    pub words: String,
    /// The cost over the sky.
    pub dome: Vec<(Vec3, f32)>,
}

/// Finds the light.
pub(crate) fn find(_: &Scene<'_>, _: &[TriangleId], _: &[Sighting], _: &Gains, _: Settings) -> Found {
    let (color, sky, spread) = ([1.0; 3], [0.2; 3], Spread::default());
    Found {
        sun: None,
        color,
        sky,
        spread,
        turned: 0.0,
        white: 1.0,
        decided: Decision::NoSun,
        words: String::new(),
        dome: Vec::new(),
    }
}
