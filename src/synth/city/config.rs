//! What a city is made from.

use serde::{Deserialize, Serialize};

use crate::base::{Error, Result};

/// A city's configuration. Everything has a default, and two equal configurations give the same files, byte for byte.
#[derive(Debug, Clone, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields, default)]
pub struct CityConfig {
    /// Seed of everything random.
    pub seed: u64,
    /// Triangles to aim at, 5,000 to 20,000,000. The town grows with it; the count is met to a fifth, below
    /// 50,000 more roughly.
    pub triangles: u32,
    /// Photographs, 1 to 100,000: two fifths on a low ring, two fifths on a high ring, the rest looking straight down.
    pub frames: u32,
    /// Columns of a photograph, 16 to 16,384.
    pub width: u32,
    /// Rows of a photograph, 16 to 16,384.
    pub height: u32,
    /// Samples of a pixel along either axis, 1 to 4. One shows a triangle a pixel; more mix them at their edges, as
    /// lenses do.
    pub supersampling: u32,
    /// The sun's height above the horizon, 5 to 90 degrees.
    pub sun_elevation_deg: f64,
    /// The sun's direction from +x towards +y, degrees.
    pub sun_azimuth_deg: f64,
    /// Radiance of the sky, linear RGB, 0 to 1: what a white Lambertian under the open sky has in the shade.
    pub sky: [f32; 3],
    /// Quality of the JPEG files, 50 to 100.
    pub jpeg_quality: u8,
}

impl Default for CityConfig {
    fn default() -> Self {
        CityConfig {
            seed: 35,
            triangles: 50_000,
            frames: 60,
            width: 1200,
            height: 900,
            supersampling: 2,
            sun_elevation_deg: 47.0,
            sun_azimuth_deg: 228.0,
            sky: [0.16, 0.19, 0.24],
            jpeg_quality: 95,
        }
    }
}

impl CityConfig {
    /// Whether every value is in its range.
    ///
    /// # Errors
    /// Names every value that is not, with its range.
    pub fn check(&self) -> Result<()> {
        let mut problems = Vec::new();
        let mut within = |name: &str, value: f64, low: f64, high: f64| {
            if !(low..=high).contains(&value) {
                problems.push(format!("{name} is {value}, but must lie in {low} to {high}"));
            }
        };
        within("triangles", f64::from(self.triangles), 5e3, 2e7);
        within("frames", f64::from(self.frames), 1.0, 1e5);
        within("width", f64::from(self.width), 16.0, 16_384.0);
        within("height", f64::from(self.height), 16.0, 16_384.0);
        within("supersampling", f64::from(self.supersampling), 1.0, 4.0);
        within("sun_elevation_deg", self.sun_elevation_deg, 5.0, 90.0);
        within("sun_azimuth_deg", self.sun_azimuth_deg, -360.0, 360.0);
        self.sky.iter().for_each(|&v| within("sky", f64::from(v), 0.0, 1.0));
        within("jpeg_quality", f64::from(self.jpeg_quality), 50.0, 100.0);
        if problems.is_empty() { Ok(()) } else { Err(Error::invalid(format!("city: {}", problems.join("; ")))) }
    }
}
