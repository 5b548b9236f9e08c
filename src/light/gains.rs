//! How each frame was exposed.

use super::observed::Sighting;

/// The logarithm of each frame's gain.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Gains {
    /// The logarithms; `None` for a frame that nothing ties to the others.
    pub log: Vec<Option<f32>>,
    /// The spread of what is left.
    pub residual: f32,
}

/// The gains of frames.
pub(crate) fn gains(sightings: &[Sighting], frames: usize, known: &[Option<f32>]) -> Gains {
    let seen = |frame: usize| sightings.iter().any(|s| s.frame as usize == frame);
    let log = (0..frames).map(|f| known.get(f).copied().flatten().or(seen(f).then_some(0.0))).collect();
    Gains { log, residual: 0.0 }
}
