//! Frames of one light belong together, and those of another apart, by their times or by what they saw.

use super::flight::{flight, uneven};
use crate::light::draw::unit;
use crate::light::{Sighting, sittings};

/// What a flight sees: `light` gives how much brighter a triangle is in the light of a frame. Exposures differ, and the shine of a
/// triangle turns with the view.
fn lit(frames: u32, light: impl Fn(u32, u32) -> f32) -> Vec<Sighting> {
    flight(frames, 0.1, |frame, _, sample| {
        let shine = 1.0 + 0.2 * (f64::from(frame) / 9.0 + f64::from(sample)).sin() as f32;
        (uneven(frame) * shine * light(frame, sample), 0.3)
    })
}

/// A triangle's brightness in one of some lights.
fn brightness(light: u32, sample: u32) -> f32 {
    0.4 + 1.2 * unit(100 + u64::from(light), u64::from(sample)) as f32
}

#[test]
fn frames_without_times_are_told_apart_by_what_they_saw() {
    let untold = vec![None; 60];
    let of = |light: &dyn Fn(u32) -> u32| sittings(&lit(60, |f, t| brightness(light(f), t)), &untold, &[]);
    assert_eq!(of(&|_| 0), vec![0; 60], "one light");
    for light in [|frame| frame % 2, |frame| u32::from(frame >= 40), |frame| u32::from(frame % 3 == 1)] {
        let found = of(&light);
        let same = (0..60).all(|f| (found[f as usize] == found[0]) == (light(f) == light(0)));
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
