//! Section `[synth.city]`: what a city is made from.

use std::fmt::Display;
use std::ops::RangeInclusive;

use serde::Serialize;

use super::world::World;
use crate::base::{Error, Result};
use crate::config::{Choice, Effect, Key, Keys, Section, Settings, Value, defaults, outside};

/// A city's configuration. Two equal configurations give the same files, byte for byte.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct CityConfig {
    /// The seed of everything random.
    pub seed: u64,
    /// Triangles to aim at. The town grows with them; the count is met to a fifth, below 50,000 more roughly.
    pub triangles: u32,
    /// Photographs: two fifths on a low ring, two fifths on a high ring, the rest looking straight down.
    pub frames: u32,
    /// Columns of a photograph.
    pub width: u32,
    /// Rows of a photograph.
    pub height: u32,
    /// Samples of a pixel along either axis. One shows a triangle a pixel; more mix triangles at their edges, as lenses do.
    pub supersampling: u32,
    /// The sun's height above the horizon, degrees.
    pub sun_elevation_deg: f64,
    /// The sun's direction from +x towards +y, degrees.
    pub sun_azimuth_deg: f64,
    /// Elevation and azimuth of two or more suns, which share out the flight in its order; where there are none, the sun above
    /// shines all the time.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub suns: Vec<[f64; 2]>,
    /// Radiance of the sky, linear RGB. A white Lambertian in the shade, under all of the sky, has this radiance too.
    pub sky: [f32; 3],
    /// Quality of the JPEG files; in the real world 80 at most.
    pub jpeg_quality: u8,
    /// The world that the city lies in.
    #[serde(skip_serializing_if = "World::is_plain")]
    pub world: World,
}

const TRIANGLES: RangeInclusive<u32> = 5000..=20_000_000;
const FRAMES: RangeInclusive<u32> = 1..=100_000;
const SIDE: RangeInclusive<u32> = 16..=16_384;
const SUPERSAMPLING: RangeInclusive<u32> = 1..=4;
const ELEVATION: RangeInclusive<f64> = 5.0..=90.0;
const AZIMUTH: RangeInclusive<f64> = -360.0..=360.0;
/// The most suns of a flight.
const SUNS: usize = 16;
const SKY: RangeInclusive<f32> = 0.0..=1.0;
const QUALITY: RangeInclusive<u8> = 50..=100;

impl Default for CityConfig {
    fn default() -> Self {
        defaults()
    }
}

impl Section for CityConfig {
    const NAME: &'static str = "synth.city";
    const ABOUT: &'static str = "The city that is made.";
    const KEYS: &'static [Key] = &[
        Key { name: "seed", doc: "The seed of everything random.", value: Value::Default("35") },
        Key { name: "triangles", doc: "Triangles to aim at, 5000 to 20000000.", value: Value::Default("50000") },
        Key { name: "frames", doc: "Photographs, 1 to 100000.", value: Value::Default("60") },
        Key { name: "width", doc: "Columns of a photograph, 16 to 16384.", value: Value::Default("1200") },
        Key { name: "height", doc: "Rows of a photograph, 16 to 16384.", value: Value::Default("900") },
        Key { name: "supersampling", doc: "Samples of a pixel along either axis, 1 to 4.", value: Value::Default("2") },
        Key {
            name: "sun_elevation_deg",
            doc: "The sun's height above the horizon, 5 to 90 degrees.",
            value: Value::Default("47.0"),
        },
        Key {
            name: "sun_azimuth_deg",
            doc: "The sun's direction from +x towards +y, -360 to 360 degrees.",
            value: Value::Default("228.0"),
        },
        Key {
            name: "suns",
            doc: "Elevation and azimuth of the suns, where there are several: the first part of the flight has the first.",
            value: Value::Default("[]"),
        },
        Key {
            name: "sky",
            doc: "Radiance of the sky, linear RGB, 0 to 1.",
            value: Value::Default("[0.16, 0.19, 0.24]"),
        },
        Key {
            name: "jpeg_quality",
            doc: "Quality of the JPEG files, 50 to 100; in the real world 80 at most.",
            value: Value::Default("95"),
        },
        Key {
            name: "world",
            doc: "\"plain\": a scene as it is assumed to be. \"real\": one with what real scenes have beyond that.",
            value: Value::Default("\"plain\""),
        },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let sky: [f32; 3] = keys.value("sky");
        keys.check("sky", sky.iter().all(|v| SKY.contains(v)), "must be three numbers, 0 to 1");
        let suns: Vec<[f64; 2]> = keys.value("suns");
        keys.check("suns", are_suns(&suns), suns_rule());
        CityConfig {
            seed: keys.value("seed"),
            triangles: keys.within("triangles", TRIANGLES),
            frames: keys.within("frames", FRAMES),
            width: keys.within("width", SIDE),
            height: keys.within("height", SIDE),
            supersampling: keys.within("supersampling", SUPERSAMPLING),
            sun_elevation_deg: keys.within("sun_elevation_deg", ELEVATION),
            sun_azimuth_deg: keys.within("sun_azimuth_deg", AZIMUTH),
            suns,
            sky,
            jpeg_quality: keys.within("jpeg_quality", QUALITY),
            world: keys.choice("world"),
        }
    }

    fn settings(&self) -> Settings {
        let CityConfig {
            seed,
            triangles,
            frames,
            width,
            height,
            supersampling,
            sun_elevation_deg,
            sun_azimuth_deg,
            suns,
            sky,
            jpeg_quality,
            world,
        } = self;
        Settings::of(Self::NAME)
            .with("seed", seed, Effect::Input)
            .with("triangles", triangles, Effect::Input)
            .with("frames", frames, Effect::Input)
            .with("width", width, Effect::Input)
            .with("height", height, Effect::Input)
            .with("supersampling", supersampling, Effect::Input)
            .with("sun_elevation_deg", sun_elevation_deg, Effect::Input)
            .with("sun_azimuth_deg", sun_azimuth_deg, Effect::Input)
            .with("suns", suns, Effect::Input)
            .with("sky", sky, Effect::Input)
            .with("jpeg_quality", jpeg_quality, Effect::Input)
            .with("world", world.name(), Effect::Input)
    }
}

impl CityConfig {
    /// Checks a configuration that was not read from a file.
    ///
    /// # Errors
    /// Names every value that is out of its range, with the range.
    pub fn check(&self) -> Result<()> {
        let mut problems = vec![
            wrong("triangles", TRIANGLES, self.triangles),
            wrong("frames", FRAMES, self.frames),
            wrong("width", SIDE, self.width),
            wrong("height", SIDE, self.height),
            wrong("supersampling", SUPERSAMPLING, self.supersampling),
            wrong("sun_elevation_deg", ELEVATION, self.sun_elevation_deg),
            wrong("sun_azimuth_deg", AZIMUTH, self.sun_azimuth_deg),
            wrong("jpeg_quality", QUALITY, self.jpeg_quality),
        ];
        problems.push((!are_suns(&self.suns)).then(|| format!("suns is {:?}, but {}", self.suns, suns_rule())));
        problems.extend(self.sky.map(|v| wrong("sky", SKY, v)));
        let problems: Vec<String> = problems.into_iter().flatten().collect();
        if problems.is_empty() { Ok(()) } else { Err(Error::invalid(format!("city: {}", problems.join("; ")))) }
    }
}

/// Whether these are several suns, or none.
fn are_suns(suns: &[[f64; 2]]) -> bool {
    let is_sun = |[elevation, azimuth]: &[f64; 2]| ELEVATION.contains(elevation) && AZIMUTH.contains(azimuth);
    suns.len() != 1 && suns.len() <= SUNS && suns.iter().all(is_sun)
}

fn suns_rule() -> String {
    let ([low, high], [from, to]) = ([ELEVATION.start(), ELEVATION.end()], [AZIMUTH.start(), AZIMUTH.end()]);
    format!("must be none, or 2 to {SUNS} of [elevation, azimuth], {low} to {high} and {from} to {to} degrees")
}

fn wrong<T: PartialOrd + Display>(key: &str, range: RangeInclusive<T>, value: T) -> Option<String> {
    outside(&range, &value).map(|problem| format!("{key} is {value}, but {}", problem.rule))
}
