//! The light that was found, and how surely.

use glam::Vec3;

/// The light that was found.
#[derive(Debug, Clone, PartialEq)]
pub struct Found {
    /// Unit vector towards the sun, in the mesh's axes; `None` if no sun could be told.
    pub sun: Option<[f64; 3]>,
    /// Radiance of a white surface that faces the sun, without the sky's part, linear RGB.
    pub color: [f32; 3],
    /// Radiance of the sky, linear RGB.
    pub sky: [f32; 3],
    /// Radiance of the scene's surfaces, which light each other where they see no sky; 0 where the photographs speak against it.
    pub bounce: [f32; 3],
    /// How sure the light is.
    pub spread: Spread,
    /// The rise of the cost when the sun is turned about up, in nats a pair: the least of three turns.
    pub turned: f32,
    /// That rise in its standard errors.
    pub turned_sure: f32,
    /// The rise of the cost when the sun is spread over a cap of 20 degrees, in its standard errors; below 0 the light is soft.
    pub soft_sure: f32,
    /// The radiance of a white surface that faces the sun, which sets the scale of albedo.
    pub white: f32,
    /// What was decided.
    pub decided: Decision,
    /// Directions over the sky and their costs; the lower, the likelier.
    pub dome: Vec<(Vec3, f32)>,
    /// Triangles that enough was seen of.
    pub triangles: usize,
    /// Pairs of them that were compared.
    pub pairs: usize,
}

/// How sure a light is: standard deviations.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Spread {
    /// The deviation of the direction, degrees.
    pub sun_degrees: f32,
    /// The deviation of the logarithm of sky over sun, per channel.
    pub ratio: [f32; 3],
    /// The deviation of the logarithm of the scale: how far the convention may be from the truth.
    pub scale: f32,
}

/// What was decided about the light.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Decision {
    /// There is a sun.
    Sun,
    /// There may be a sun: it is given, but it should be checked.
    Doubtful,
    /// There is none, or it cannot be told: the light is the sky's.
    NoSun,
    /// Too little was seen to tell any light.
    TooLittle,
}
