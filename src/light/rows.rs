//! The sightings that tell of exposure.

use super::observed::Sighting;

/// The number of pixels at which a sighting counts for half.
const FEW: f64 = 10.0;

/// A sighting that tells of exposure.
#[derive(Debug, Clone, Copy)]
pub(super) struct Row {
    /// The frame.
    pub frame: usize,
    /// The triangle, counted among those that are used.
    pub triangle: usize,
    /// Logarithm of the luminance.
    pub log: f64,
    /// The weight that its pixels give it.
    pub share: f64,
    /// The squared distance from the image's centre.
    pub radius2: f64,
}

/// The sightings that tell of exposure, triangle by triangle: bright enough, hardly clipped, of triangles that several frames
/// see.
pub(super) fn rows(sightings: &[Sighting], frames: usize) -> Vec<Row> {
    let usable = |s: &&Sighting| {
        let (luma, hardly) = (s.luma(), 10 * u64::from(s.clipped) < u64::from(s.pixels));
        s.pixels >= 3 && hardly && luma > 0.004 && luma.is_finite() && (s.frame as usize) < frames
    };
    let mut usable: Vec<&Sighting> = sightings.iter().filter(usable).collect();
    usable.sort_unstable_by_key(|s| (s.sample, s.frame));
    let several = usable.chunk_by(|a, b| a.sample == b.sample).filter(|of_one| of_one.len() > 1);
    let row = |triangle: usize, s: &Sighting| {
        let pixels = f64::from(s.pixels);
        let (log, share) = (f64::from(s.luma()).ln(), pixels / (pixels + FEW));
        Row { frame: s.frame as usize, triangle, log, share, radius2: f64::from(s.radius2) }
    };
    several.enumerate().flat_map(|(triangle, of_one)| of_one.iter().map(move |s| row(triangle, s))).collect()
}
