//! A flight over made-up triangles.

use crate::light::Sighting;
use crate::light::draw::unit;

/// Frames in a row of which each sees a window of 120 triangles, every one a little off by `noise`. `shown` gives by how much a frame
/// shows the k-th triangle of its window brighter than it is, and at which squared radius: of frame, k, and the triangle.
pub(super) fn flight(frames: u32, noise: f64, shown: impl Fn(u32, u32, u32) -> (f32, f32)) -> Vec<Sighting> {
    let sighting = |frame: u32, k: u32| {
        let sample = 20 * frame + k;
        let kd = 0.05 + 0.4 * unit(1, u64::from(sample)) as f32;
        let off = 1.0 + noise * (unit(u64::from(frame) + 10, u64::from(sample)) - 0.5);
        let (brighter, radius2) = shown(frame, k, sample);
        let mean = [kd * off as f32 * brighter; 3];
        Sighting { frame, sample, pixels: 40, clipped: 0, mean, radius2 }
    };
    (0..frames).flat_map(|frame| (0..120).map(move |k| (frame, k))).map(|(frame, k)| sighting(frame, k)).collect()
}

/// A gain of 0.7 to 1.3.
pub(super) fn uneven(frame: u32) -> f32 {
    0.7 + 0.6 * unit(2, u64::from(frame)) as f32
}

/// Every tenth sighting is a highlight.
pub(super) fn shine(frame: u32, k: u32) -> f32 {
    if (frame + 7 * k).is_multiple_of(10) { 1.5 } else { 1.0 }
}
