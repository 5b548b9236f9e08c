//! `light.json`, which says what was found of exposures and light, and `light.png`, the cost of a sun over the sky: dark where the
//! photographs speak for it. Both depend on what is frozen alone.

use std::collections::BTreeMap;
use std::io::Write;

use glam::{DVec3, Vec2, Vec3};
use serde::Serialize;

use super::found::{Decided, FoundLight, Moved};
use super::frozen::State;
use crate::base::convert::Cut;
use crate::base::{Error, Result};
use crate::codec::images::encode_png;
use crate::disk::{FileEntry, Store};
use crate::scene::vignetting::Vignetting;

/// The file that says what was found.
pub(crate) const LIGHT: &str = "light.json";

/// The picture of the cost over the sky.
pub(crate) const DOME: &str = "light.png";

/// The picture's columns, and rows.
const SIDE: u32 = 360;

/// What `light.json` says.
#[derive(Serialize)]
struct Told<'a> {
    /// Towards the sun, in the mesh's coordinates; null where none was found.
    sun: Option<[f64; 3]>,
    /// Radiance of a white surface that faces the sun, without the sky's part.
    color: Option<[f32; 3]>,
    /// The sky's radiance.
    sky: Option<[f32; 3]>,
    /// Radiance of the scene's surfaces, which light each other where they see no sky.
    bounce: Option<[f32; 3]>,
    spread: Option<Spread>,
    /// The least rise of the cost where the sun is turned about up.
    turned: Option<f32>,
    white: Option<f32>,
    decided: Option<Decided>,
    words: Option<&'a str>,
    moved: Option<&'a Moved>,
    /// The lights of frames that were not taken in this one.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    others: Vec<Other<'a>>,
    gains: Exposures<'a>,
}

/// Another light, in the units of the first.
#[derive(Serialize)]
struct Other<'a> {
    sun: Option<[f64; 3]>,
    color: [f32; 3],
    sky: [f32; 3],
    bounce: [f32; 3],
    spread: Spread,
    decided: Decided,
    words: &'a str,
    frames: Vec<&'a str>,
}

impl<'a> Other<'a> {
    /// The lights of frames that were not taken in this one.
    fn all(light: &'a FoundLight, state: &'a State) -> Vec<Self> {
        light.others.iter().zip(1..).map(|(other, at)| Other::of(other, at, state)).collect()
    }

    /// The light at a position in the list of lights.
    fn of(light: &'a FoundLight, at: usize, state: &'a State) -> Self {
        let FoundLight { sun, color, sky, bounce, decided, ref words, .. } = *light;
        let frames = state.taken_in.iter().filter(|(_, light)| **light == at).map(|(name, _)| name.as_str()).collect();
        Other { sun, color, sky, bounce, spread: Spread::of(light), decided, words, frames }
    }
}

/// One standard deviation each: of the sun's direction, and of logarithms.
#[derive(Serialize)]
struct Spread {
    sun_degrees: f32,
    sky_over_sun: [f32; 3],
    scale: f32,
}

impl Spread {
    fn of(light: &FoundLight) -> Self {
        Spread { sun_degrees: light.sun_degrees, sky_over_sun: light.ratio, scale: light.scale }
    }
}

#[derive(Serialize)]
struct Exposures<'a> {
    /// What each frame's radiance is divided by.
    frames: BTreeMap<&'a str, f32>,
    /// Frames that nothing ties to the others: their gain is 1.
    untied: &'a [String],
    residual: f32,
    /// The correlation of their logarithms with those of the exposures that the photographs tell.
    exif: Option<f32>,
    /// By the size of their images, how much darker cameras are towards their corners.
    vignetting: &'a BTreeMap<String, Vignetting>,
}

/// Writes both files.
///
/// # Errors
/// A store that fails.
pub(super) fn write(store: &dyn Store, state: &State, up: [f64; 3]) -> Result<Vec<FileEntry>> {
    let light = state.light.as_ref();
    let told = Told {
        sun: light.and_then(|light| light.sun),
        color: light.map(|light| light.color),
        sky: light.map(|light| light.sky),
        bounce: light.map(|light| light.bounce),
        spread: light.map(Spread::of),
        turned: light.map(|light| light.turned),
        white: light.map(|light| light.white),
        decided: light.map(|light| light.decided),
        words: light.map(|light| light.words.as_str()),
        moved: state.moved.as_ref(),
        others: light.map(|light| Other::all(light, state)).unwrap_or_default(),
        gains: Exposures {
            frames: state.gains.iter().map(|(name, gain)| (name.as_str(), gain.log.exp())).collect(),
            untied: &state.untied,
            residual: state.residual,
            exif: state.exif,
            vignetting: &state.vignetting,
        },
    };
    let failed = |name: &str| Error::io("write", store.path(name));
    let mut file = store.create(LIGHT)?;
    serde_json::to_writer_pretty(&mut file, &told).map_err(|why| failed(LIGHT)(why.into()))?;
    file.write_all(b"\n").map_err(failed(LIGHT))?;
    let mut files = vec![file.replace()?];
    if let Some(light) = light.filter(|light| !light.dome.is_empty()) {
        let mut file = store.create(DOME)?;
        encode_png(&mut file, &picture(light, up), SIDE, SIDE).map_err(failed(DOME))?;
        files.push(file.replace()?);
    }
    Ok(files)
}

/// The sky from below, up in the middle and the horizon around it: the nearest direction's cost, and a red ring around the sun.
fn picture(light: &FoundLight, up: [f64; 3]) -> Vec<[u8; 3]> {
    let up = DVec3::from(up).as_vec3().normalize_or_zero();
    let (east, north) = up.any_orthonormal_pair();
    let costs = || light.dome.iter().map(|row| row[3]);
    let (low, high) = costs().fold((f32::INFINITY, f32::NEG_INFINITY), |(l, h), cost| (l.min(cost), h.max(cost)));
    let sun = light.sun.map(|sun| DVec3::from(sun).as_vec3().normalize_or_zero());
    let pixel = |at: u32| {
        let place = (Vec2::new((at % SIDE) as f32, (at / SIDE) as f32) + 0.5) / SIDE as f32 * 2.0 - 1.0;
        let Some(direction) = lifted(place, [east, north, up]) else { return [255; 3] };
        if sun.is_some_and(|sun| (0.04..0.06).contains(&sun.angle_between(direction))) {
            return [220, 30, 30];
        }
        let nearest = |row: &&[f32; 4]| Vec3::new(row[0], row[1], row[2]).dot(direction);
        let cost = light.dome.iter().max_by(|a, b| nearest(a).total_cmp(&nearest(b))).map_or(low, |row| row[3]);
        [u8::cut(255.0 * (cost - low) / (high - low).max(f32::MIN_POSITIVE)); 3]
    };
    (0..SIDE * SIDE).map(pixel).collect()
}

/// The direction at a place of the disk, whose distance from the middle is the angle to up over a right angle.
fn lifted(place: Vec2, [east, north, up]: [Vec3; 3]) -> Option<Vec3> {
    let angle = place.length() * std::f32::consts::FRAC_PI_2;
    let around = place.normalize_or_zero();
    (place.length() <= 1.0).then(|| (east * around.x - north * around.y) * angle.sin() + up * angle.cos())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_picture_has_up_in_its_middle_and_the_horizon_around_it() {
        let axes = [Vec3::X, Vec3::Y, Vec3::Z];
        assert_eq!(lifted(Vec2::ZERO, axes), Some(Vec3::Z));
        assert!(lifted(Vec2::X, axes).is_some_and(|at| at.distance(Vec3::X) < 1e-6));
        assert!(
            lifted(Vec2::NEG_Y * 0.5, axes)
                .is_some_and(|at| at.distance(Vec3::new(0.0, 0.5, 0.5) * 2f32.sqrt()) < 1e-6)
        );
        assert_eq!(lifted(Vec2::ONE, axes), None);
    }
}
