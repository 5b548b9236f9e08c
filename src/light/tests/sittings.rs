//! Frames of one light belong together, and those of another apart, by their times or by what they saw.

use crate::light::draw::unit;
use crate::light::{Sighting, sittings};

/// Frames in a row of which each sees a window of triangles: `light` gives the light of each, and how much brighter a triangle is
/// in it. Exposures differ, and views drift apart.
fn flight(frames: u32, light: impl Fn(u32, u32) -> f32) -> Vec<Sighting> {
    let mut seen = Vec::new();
    for frame in 0..frames {
        for k in 0..120 {
            let sample = 20 * frame + k;
            let kd = 0.05 + 0.4 * unit(1, u64::from(sample)) as f32;
            let noise = 1.0 + 0.1 * (unit(u64::from(frame) + 10, u64::from(sample)) - 0.5) as f32;
            let gain = 0.7 + 0.6 * unit(2, u64::from(frame)) as f32;
            // The shine of a triangle turns with the view.
            let shine = 1.0 + 0.2 * (f64::from(frame) / 9.0 + f64::from(sample)).sin() as f32;
            let mean = [kd * gain * noise * shine * light(frame, sample); 3];
            seen.push(Sighting { frame, sample, pixels: 40, clipped: 0, mean, radius2: 0.3 });
        }
    }
    seen
}

/// A triangle's brightness in one of some lights.
fn brightness(light: u32, sample: u32) -> f32 {
    0.4 + 1.2 * unit(100 + u64::from(light), u64::from(sample)) as f32
}

#[test]
fn frames_without_times_are_told_apart_by_what_they_saw() {
    let untold = vec![None; 60];
    let of = |lit: &dyn Fn(u32) -> u32| sittings(&flight(60, |f, t| brightness(lit(f), t)), &untold, &[]);
    assert_eq!(of(&|_| 0), vec![0; 60], "one light");
    for lit in [|frame| frame % 2, |frame| u32::from(frame >= 40), |frame| u32::from(frame % 3 == 1)] {
        let found = of(&lit);
        let same = (0..60).all(|f| (found[f as usize] == found[0]) == (lit(f) == lit(0)));
        assert!(same, "{found:?}");
    }
    let found = of(&|frame| frame / 20);
    assert!((0..60).all(|f| found[f] == found[f / 20 * 20]), "{found:?}");
    assert!(found[0] != found[20] && found[20] != found[40] && found[0] != found[40], "{found:?}");
    // Too few to be a light.
    assert_eq!(of(&|frame| u32::from(frame == 7)), vec![0; 60]);
}

#[test]
fn times_tell_sittings_that_last_no_longer_than_half_an_hour() {
    let of = |minutes: &[Option<i64>]| {
        let times: Vec<Option<i64>> = minutes.iter().map(|minute| minute.map(|minute| 60 * minute)).collect();
        sittings(&[], &times, &[])
    };
    let told = |minutes: &[i64]| of(&minutes.iter().map(|minute| Some(*minute)).collect::<Vec<_>>());
    assert_eq!(told(&[0, 10, 30]), [0, 0, 0]);
    assert_eq!(told(&[500, 0, 510, 20]), [1, 0, 1, 0]);
    assert_eq!(told(&[0, 20, 40, 60]), [0, 0, 1, 1]);
    // Four days are more lights than are told apart: those nearest to each other share one.
    assert_eq!(told(&[0, 1440, 2880, 3000]), [0, 1, 2, 2]);
    // What has no time is given to most; times that are all the same tell nothing.
    assert_eq!(of(&[Some(0), Some(300), None, Some(301)]), [0, 1, 1, 1]);
    assert_eq!(told(&[7, 7, 7]), [0, 0, 0]);
}

#[test]
fn frames_that_come_join_the_nearest_in_time_and_move_nothing() {
    let times = [Some(0), Some(9000), Some(4000), Some(5000), None];
    assert_eq!(sittings(&[], &times, &[Some(1), Some(0), None, None, None]), [1, 0, 1, 0, 0]);
}
