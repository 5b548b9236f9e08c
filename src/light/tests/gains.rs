//! Gains that are known are found, and frames that nothing ties are left alone.

use super::flight::{flight, shine, uneven};
use crate::light::draw::unit;
use crate::light::{Gains, Sighting, gains};

/// What a flight of these gains sees.
fn exposed(frames: u32, gain: impl Fn(u32) -> f32, noise: f64) -> Vec<Sighting> {
    flight(frames, noise, |frame, k, _| (gain(frame) * shine(frame, k), 0.3))
}

/// The root mean square of the found logarithms against the true ones, less the common offset.
fn off(found: &Gains, frames: u32, gain: impl Fn(u32) -> f32) -> f32 {
    let off: Vec<f32> = (0..frames).map(|f| found.log[f as usize].expect("the frame is tied") - gain(f).ln()).collect();
    let mean = off.iter().sum::<f32>() / off.len() as f32;
    (off.iter().map(|o| (o - mean).powi(2)).sum::<f32>() / off.len() as f32).sqrt()
}

#[test]
fn gains_of_thirty_percent_are_recovered() {
    let found = gains(&exposed(60, uneven, 0.1), 60, &[]);
    assert!(off(&found, 60, uneven) < 0.015, "{}", off(&found, 60, uneven));
    assert!((0.01..0.08).contains(&found.residual), "{}", found.residual);
    let mut sorted: Vec<f32> = found.log.iter().flatten().copied().collect();
    sorted.sort_by(f32::total_cmp);
    assert_eq!(sorted[30], 0.0, "the median frame is the reference");
}

#[test]
fn frames_in_any_order_of_rows_give_the_same_bits() {
    let gain = |frame: u32| 1.0 + 0.1 * (frame % 3) as f32;
    let mut seen = exposed(20, gain, 0.1);
    let found = gains(&seen, 20, &[]);
    assert!(found.log.iter().all(Option::is_some), "every frame is tied");
    seen.reverse();
    assert_eq!(gains(&seen, 20, &[]), found);
}

#[test]
fn a_frame_that_nothing_ties_has_no_gain() {
    let mut seen = exposed(10, |_| 1.0, 0.05);
    // Two frames that share triangles with each other alone, and one that shares too few.
    for (frame, first, count) in [(10, 5000u32, 50u32), (11, 5000, 50), (12, 0, 4)] {
        let one = |k: u32| Sighting { frame, sample: first + k, pixels: 40, clipped: 0, mean: [0.2; 3], radius2: 0.0 };
        seen.extend((0..count).map(one));
    }
    let found = gains(&seen, 14, &[]);
    let none: Vec<usize> = (0..14).filter(|&f| found.log[f].is_none()).collect();
    assert_eq!(none, [10, 11, 12, 13]);
    assert_eq!((found.factor(10), found.factor(99)), (None, None));
    // Known gains tie both parts.
    let mut known = vec![None; 14];
    (known[3], known[11]) = (Some(0.0), Some(0.5));
    let found = gains(&seen, 14, &known);
    assert!((found.log[10].expect("tied") - 0.5).abs() < 1e-3 && found.log[12].is_none());
}

#[test]
fn gains_that_are_known_stay_and_new_frames_join_them() {
    let gain = |frame: u32| 0.7 + 0.6 * unit(3, u64::from(frame)) as f32;
    let seen = exposed(30, gain, 0.05);
    let first: Vec<Sighting> = seen.iter().copied().filter(|s| s.frame < 20).collect();
    let before = gains(&first, 20, &[]);
    let after = gains(&seen, 30, &before.log);
    assert_eq!(after.log[..20], before.log[..]);
    assert!(off(&after, 30, gain) < 0.01, "{}", off(&after, 30, gain));
}

#[test]
fn clipped_dark_and_broken_sightings_tell_nothing() {
    let gain = |frame: u32| 1.0 + 0.2 * (frame % 2) as f32;
    let mut seen = exposed(12, gain, 0.0);
    let clean = gains(&seen, 12, &[]);
    assert!(clean.log.iter().all(Option::is_some), "every frame is tied");
    for (mean, clipped) in [([0.9; 3], 20), ([0.001; 3], 0), ([f32::NAN; 3], 0), ([f32::INFINITY; 3], 0)] {
        seen.extend((0..300).map(|sample| Sighting { frame: 5, sample, pixels: 40, clipped, mean, radius2: 0.0 }));
    }
    seen.push(Sighting { frame: u32::MAX, sample: 0, pixels: 40, clipped: 0, mean: [0.5; 3], radius2: 0.0 });
    assert_eq!(gains(&seen, 12, &[]), clean);
    assert_eq!(gains(&[], 2, &[]).log, [None, None]);
}
