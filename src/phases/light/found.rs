//! What was found of gains and light, as it is kept.

use std::collections::BTreeMap;

use glam::{DVec3, Vec3};
use serde::{Deserialize, Serialize};

use crate::base::key::Key;
use crate::light::{Decision, Found};
use crate::scene::frame::Frame;
use crate::scene::light::Sun;
use crate::scene::vignetting::Vignetting;
use crate::stages::scene_light::{Doubts, SunAndSky};

/// The gain of a frame.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Gain {
    /// The logarithm of what the frame's radiance is divided by.
    pub log: f32,
    /// The content of the image that it was found for, as recipes have it.
    pub image: String,
}

/// What is known of a sun.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub(crate) enum Decided {
    /// The sun shone.
    Sun,
    /// No sun shone.
    NoSun,
    /// There may have been a sun.
    Doubtful,
    /// Too little was seen to tell.
    TooLittle,
}

/// A light that was found.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct FoundLight {
    /// Unit vector towards the sun, in the mesh's coordinates.
    pub sun: Option<[f64; 3]>,
    /// Radiance of a white surface that faces the sun, without the sky's part.
    pub color: [f32; 3],
    /// The sky's radiance.
    pub sky: [f32; 3],
    /// Radiance of the scene's surfaces, which light each other.
    #[serde(default)]
    pub bounce: [f32; 3],
    /// One standard deviation of the sun's direction, degrees.
    pub sun_degrees: f32,
    /// One standard deviation of the logarithm of sky over sun, by channel.
    pub ratio: [f32; 3],
    /// One standard deviation of the logarithm of the scale.
    pub scale: f32,
    /// The least rise of the cost where the sun is turned about up.
    pub turned: f32,
    /// Radiance of a white surface that faces the sun, as it was set or found.
    pub white: f32,
    /// What was decided.
    pub decided: Decided,
    /// How it was decided, in words.
    pub words: String,
    /// What the photographs say against the sun of place and time.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub doubt: Option<String>,
    /// Directions over the sky, each with the cost of a sun there.
    pub dome: Vec<[f32; 4]>,
    /// The lights of frames that were not taken in this one.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub others: Vec<FoundLight>,
}

/// That the light was looked for again, and found elsewhere.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Moved {
    /// What was found, in words.
    pub words: String,
    /// Unit vector towards the sun that was found now, in the mesh's coordinates.
    pub sun: Option<[f64; 3]>,
}

/// What was found of the sightings of one moment; what was known before stays.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Looked {
    /// What the gains depend on beside the sightings.
    pub gains_under: Key,
    /// What the light depends on beside the sightings.
    pub light_under: Key,
    /// The sightings.
    pub sightings: Key,
    /// Gains that were not known, by the names of the frames.
    pub gains: BTreeMap<String, Gain>,
    /// Frames that nothing ties to the others.
    pub untied: Vec<String>,
    /// The spread of what the gains leave.
    pub residual: f32,
    /// How much darker cameras are towards their corners, by the size of their images, where that was not known.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub vignetting: BTreeMap<String, Vignetting>,
    /// The correlation of the gains with the exposures that the photographs tell, where they do.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub exif: Option<f32>,
    /// The positions of the lights that frames were taken in; none where all were taken in one.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub taken_in: BTreeMap<String, usize>,
    /// The light, where none was known.
    pub light: Option<FoundLight>,
    /// That the light would be found elsewhere now.
    pub moved: Option<Moved>,
}

/// What stands for the camera of a frame: the size of its images.
pub(crate) fn camera_of(frame: &Frame) -> String {
    format!("{}x{}", frame.camera.width, frame.camera.height)
}

/// How a light was decided.
fn words(found: &Found) -> String {
    let Found { turned, triangles, pairs, .. } = found;
    let seen = format!("{pairs} pairs of {triangles} triangles");
    match found.decided {
        Decision::Sun => format!("{seen} fit a sun elsewhere worse by {turned:.2}"),
        Decision::Doubtful => {
            format!(
                "{seen} fit a sun elsewhere little worse, by {turned:.2}: hold it against what you know of place and time"
            )
        }
        Decision::NoSun => {
            format!(
                "{seen} fit no sun much better than another ({turned:.2}): the sky was overcast, or what was seen lies too \
                 much in one plane to tell; the sky's light is taken for all there is"
            )
        }
        Decision::TooLittle => format!("{seen} are too few to tell the light from"),
    }
}

/// A number that JSON can hold.
fn finite(value: f32) -> f32 {
    if value.is_finite() { value } else { f32::MAX.copysign(value) }
}

impl FoundLight {
    /// The light, as it is kept.
    pub(super) fn of(found: &Found) -> Self {
        let decided = match found.decided {
            Decision::Sun => Decided::Sun,
            Decision::NoSun => Decided::NoSun,
            Decision::Doubtful => Decided::Doubtful,
            Decision::TooLittle => Decided::TooLittle,
        };
        let dome = found.dome.iter().map(|(at, cost)| [at.x, at.y, at.z, *cost]);
        FoundLight {
            sun: found.sun,
            color: found.color.map(finite),
            sky: found.sky.map(finite),
            bounce: found.bounce.map(finite),
            sun_degrees: finite(found.spread.sun_degrees),
            ratio: found.spread.ratio.map(finite),
            scale: finite(found.spread.scale),
            turned: finite(found.turned),
            white: finite(found.white),
            decided,
            words: words(found),
            doubt: None,
            dome: dome.filter(|row| row.iter().all(|v| v.is_finite())).collect(),
            others: Vec::new(),
        }
    }

    /// This light, and those of frames that were not taken in it.
    pub(crate) fn all(&self) -> impl Iterator<Item = &FoundLight> {
        std::iter::once(self).chain(&self.others)
    }

    /// The sun that is reckoned with, if one is. One that is doubtful is: the user is told to check it.
    pub(super) fn told_sun(&self) -> Option<[f64; 3]> {
        self.sun.filter(|_| matches!(self.decided, Decided::Sun | Decided::Doubtful))
    }

    /// Sun and sky, or the sky alone where no sun shone; none where too little was seen.
    pub(crate) fn sun_and_sky(&self) -> Option<SunAndSky> {
        let direction = self.told_sun().map(|sun| DVec3::from(sun).as_vec3());
        let sun = match (direction, self.decided) {
            (Some(direction), _) => Sun { direction: direction.normalize_or_zero(), color: Vec3::from(self.color) },
            (None, Decided::NoSun) => Sun { direction: Vec3::Z, color: Vec3::ZERO },
            (None, _) => return None,
        };
        let doubts = Doubts { sun: self.sun_degrees.to_radians(), ratio: Vec3::from(self.ratio) };
        Some(SunAndSky { sun, sky: Vec3::from(self.sky), bounce: Vec3::from(self.bounce), doubts })
    }

    /// What a light that is found now says against this one, if it lies beyond the spread of both.
    pub(super) fn against(&self, now: &FoundLight) -> Option<Moved> {
        let words = match (self.sun, now.sun) {
            (None, None) => return None,
            (Some(_), None) => format!("the photographs that are there now show no sun: {}", now.words),
            (None, Some(_)) => "the photographs that are there now show a sun, where none was found before".to_owned(),
            (Some(before), Some(after)) => {
                let apart = DVec3::from(before).angle_between(DVec3::from(after)).to_degrees();
                let allowed = f64::from(2.0 * (self.sun_degrees + now.sun_degrees)).max(LEAST_DEGREES);
                if apart <= allowed || apart.is_nan() {
                    return None;
                }
                format!(
                    "the photographs that are there now put the sun {apart:.1} degrees from where it was found before"
                )
            }
        };
        Some(Moved { words, sun: now.sun })
    }
}

/// Suns less far apart are one sun.
const LEAST_DEGREES: f64 = 2.0;

#[cfg(test)]
mod tests {
    use super::*;

    fn light(sun: Option<[f64; 3]>, sun_degrees: f32) -> FoundLight {
        FoundLight {
            sun,
            color: [1.0; 3],
            sky: [0.2; 3],
            bounce: [0.0; 3],
            sun_degrees,
            ratio: [0.1; 3],
            scale: 0.2,
            turned: 1.0,
            white: 1.0,
            decided: if sun.is_some() { Decided::Sun } else { Decided::NoSun },
            words: String::new(),
            doubt: None,
            dome: Vec::new(),
            others: Vec::new(),
        }
    }

    #[test]
    fn a_light_is_contradicted_by_what_lies_beyond_its_spread_alone() {
        let at = |degrees: f64| Some([degrees.to_radians().cos(), degrees.to_radians().sin(), 0.0]);
        let moved = |before, now, spread| light(before, spread).against(&light(now, spread)).map(|moved| moved.words);
        assert_eq!(moved(at(0.0), at(1.9), 0.1), None, "suns less far apart are one");
        assert!(moved(at(0.0), at(2.1), 0.1).is_some_and(|words| words.contains("2.1 degrees")));
        assert_eq!(moved(at(0.0), at(7.9), 2.0), None);
        assert!(moved(at(0.0), at(8.1), 2.0).is_some());
        assert!(moved(at(0.0), None, 2.0).is_some() && moved(None, at(0.0), 2.0).is_some());
        assert_eq!(moved(None, None, 2.0), None);
    }

    #[test]
    fn a_doubtful_sun_is_reckoned_with_and_where_there_is_none_the_sky_is() {
        let decided = |decided| FoundLight { decided, ..light(Some([0.0, 0.0, 2.0]), 1.0) }.sun_and_sky();
        assert_eq!(decided(Decided::Sun).map(|light| light.sun.direction), Some(Vec3::Z));
        assert_eq!(decided(Decided::Doubtful), decided(Decided::Sun));
        assert_eq!(decided(Decided::NoSun).map(|light| light.sun.color), Some(Vec3::ZERO));
        assert_eq!(decided(Decided::TooLittle), None);
        let overcast = light(None, 1.0).sun_and_sky();
        assert_eq!(overcast.map(|light| (light.sun.color, light.sky)), Some((Vec3::ZERO, Vec3::splat(0.2))));
        assert_eq!(FoundLight { decided: Decided::TooLittle, ..light(None, 1.0) }.sun_and_sky(), None);
    }
}
