//! The flight: the poses that photographs are taken from.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::CityConfig;
use super::town::Town;
use crate::scene::camera::{Camera, Lens};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// Half the edge of the town that the lengths below are for, metres; they scale with the town.
const REACH: f64 = 66.0;

/// A ring of the orbit, in metres.
struct Ring {
    /// Distance from the middle of the town.
    radius: f64,
    height: f64,
    /// Distance from the middle, on the near side, of the point that the camera aims at.
    aim: f64,
}

const RINGS: [Ring; 2] =
    [Ring { radius: 90.0, height: 54.0, aim: 27.0 }, Ring { radius: 54.0, height: 76.0, aim: 10.0 }];

/// Height of the frames that look straight down, metres.
const NADIR: f64 = 86.0;

/// The frames sorted by name: two fifths on a low ring, two fifths on a high ring, the rest looking straight down from a
/// grid over the town. `scale` enlarges the images; 1 gives the photographs' own size.
pub(super) fn frames(config: &CityConfig, town: &Town, scale: u32) -> Vec<Frame> {
    let size = DVec2::new(f64::from(config.width), f64::from(config.height)) * f64::from(scale);
    // A field of view of 62 degrees across, that of a drone's wide lens.
    let lens = Lens::pinhole(DVec2::splat(0.832 * size.x), size * 0.5);
    let camera = Arc::new(Camera { width: config.width * scale, height: config.height * scale, lens });
    (0..config.frames)
        .map(|k| Frame {
            name: format!("frame_{k:03}.jpg"),
            camera: camera.clone(),
            pose: pose(config.frames, k, town),
        })
        .collect()
}

/// The pose of frame `k` of `count`.
fn pose(count: u32, k: u32, town: &Town) -> Pose {
    let scale = town.reach() / REACH;
    let ring = (2 * count).div_ceil(5);
    if k < 2 * ring && k < count {
        let Ring { radius, height, aim } = RINGS[(k / ring) as usize];
        // The rings start apart, so that their frames interleave.
        let turn = TAU * (f64::from(k % ring) + 0.5 * f64::from(k / ring)) / f64::from(ring);
        let way = DVec2::from_angle(turn);
        let (eye, target) = ((way * (radius * scale)).extend(height * scale), (way * (aim * scale)).extend(0.0));
        return Pose::look_at(eye, target, DVec3::Z);
    }
    let left = count - 2 * ring;
    let columns = f64::from(left).sqrt().ceil();
    let rows = (f64::from(left) / columns).ceil();
    let (row, column) = ((f64::from(k - 2 * ring) / columns).floor(), f64::from(k - 2 * ring) % columns);
    let across = |i: f64, n: f64| ((i + 0.5) / n - 0.5) * 1.5 * town.reach();
    let eye = DVec2::new(across(column, columns), across(row, rows)).extend(NADIR * scale);
    // A flight back and forth: every other row is flown the other way.
    let up = if row % 2.0 == 0.0 { DVec3::Y } else { DVec3::NEG_Y };
    Pose::look_at(eye, eye - DVec3::Z, up)
}
