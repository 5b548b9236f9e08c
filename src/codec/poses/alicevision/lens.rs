//! A lens of AliceVision. `focalLength` is in millimetres of `sensorWidth`; `principalPoint` counts from the centre of the
//! image since version 1.2.1, from its corner before; `pixelRatio` changed its meaning twice.

use glam::DVec2;
use serde::Deserialize;

use crate::base::convert::Cut;
use crate::base::shown::shown;
use crate::codec::poses::json::Number;
use crate::scene::camera::{Camera, Distortion, Lens, Projection};

/// A lens as the file has it.
#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
pub(super) struct Intrinsic {
    /// The lens's id.
    pub intrinsic_id: String,
    width: Number,
    height: Number,
    sensor_width: Option<Number>,
    #[serde(rename = "type")]
    kind: String,
    distortion_type: Option<String>,
    undistortion_type: Option<String>,
    focal_length: Option<Number>,
    px_focal_length: Option<OneOrTwo>,
    pixel_ratio: Option<Number>,
    principal_point: [Number; 2],
    /// An empty list is written as an empty string.
    #[serde(default)]
    distortion_params: Listed,
}

#[derive(Debug, Clone, Copy, Deserialize)]
#[serde(untagged)]
enum OneOrTwo {
    One(Number),
    Two([Number; 2]),
}

#[derive(Debug, Clone, Deserialize)]
#[serde(untagged)]
enum Listed {
    Numbers(Vec<Number>),
    Nothing(serde::de::IgnoredAny),
}

impl Default for Listed {
    fn default() -> Self {
        Listed::Numbers(Vec::new())
    }
}

/// The sensor's width where the file does not say, millimetres.
const FULL_FRAME: f64 = 36.0;

impl Intrinsic {
    /// The camera.
    ///
    /// # Errors
    /// In words: a distortion that no lens has, a number of terms that it does not have, a parameter out of range.
    pub(super) fn camera(&self, version: [u64; 3]) -> Result<Camera, String> {
        let (width, height) = (pixels("width", self.width)?, pixels("height", self.height)?);
        let size = DVec2::new(width.into(), height.into());
        let point = DVec2::from(self.principal_point.map(|number| number.0));
        let centre = if version < [1, 2, 1] { point } else { point + size * 0.5 };
        let lens = Lens::new(self.focal(version, size.x)?, centre, self.projection()?)?;
        Camera::new(width.into(), height.into(), lens)
    }

    fn focal(&self, version: [u64; 3], width: f64) -> Result<DVec2, String> {
        if version < [1, 2, 2] {
            return match self.px_focal_length {
                Some(OneOrTwo::One(both)) => Ok(DVec2::splat(both.0)),
                Some(OneOrTwo::Two(each)) => Ok(DVec2::from(each.map(|number| number.0))),
                None => Err("pxFocalLength is needed".to_owned()),
            };
        }
        let millimetres = self.focal_length.ok_or("focalLength is needed")?.0;
        let focal = millimetres * width / self.sensor_width.map_or(FULL_FRAME, |number| number.0);
        let ratio = self.pixel_ratio.map_or(1.0, |number| number.0);
        Ok(match version {
            v if v < [1, 2, 5] => DVec2::new(focal, focal / ratio),
            v if v < [1, 2, 11] => DVec2::new(focal, focal * ratio),
            _ => DVec2::new(focal / ratio, focal),
        })
    }

    fn projection(&self) -> Result<Projection, String> {
        let kind = self.kind.to_lowercase();
        let distortion = match (kind.as_str(), self.distortion_type.as_deref()) {
            // Newer files say the distortion beside the type.
            ("pinhole", Some(distortion)) => distortion.to_lowercase(),
            ("pinhole", None) => "none".to_owned(),
            _ => kind,
        };
        if let Some(other) = self.undistortion_type.as_deref().filter(|other| !other.eq_ignore_ascii_case("none")) {
            let advice = "undistort the photographs";
            return Err(format!("its undistortion is {}, and no lens of gonio has it: {advice}", shown(other)));
        }
        let flat = |distortion| Ok(Projection::Perspective(distortion));
        match distortion.as_str() {
            "none" => Ok(Projection::Pinhole),
            "radial1" | "radialk1" => flat(Distortion::radial(self.terms::<1>(&distortion)?)),
            "radial3" | "radialk3" => flat(Distortion::radial(self.terms::<3>(&distortion)?)),
            "brown" => {
                let [k1, k2, k3, t1, t2] = self.terms(&distortion)?;
                flat(Distortion { tangential: [t1, t2], ..Distortion::radial([k1, k2, k3]) })
            }
            "fisheye4" | "fisheye" => Ok(Projection::Equidistant(Distortion::radial(self.terms::<4>(&distortion)?))),
            other => {
                let known = "none, radialk1, radialk3, brown and fisheye";
                Err(format!("its lens is {}, and no lens of gonio has it; {known} are read", shown(other)))
            }
        }
    }

    fn terms<const N: usize>(&self, kind: &str) -> Result<[f64; N], String> {
        let terms: Vec<f64> = match &self.distortion_params {
            Listed::Numbers(terms) => terms.iter().map(|number| number.0).collect(),
            Listed::Nothing(_) => Vec::new(),
        };
        let found = terms.len();
        terms.try_into().map_err(|_| format!("{kind} has {N} distortionParams, and {found} are given"))
    }
}

/// A side of an image.
///
/// # Errors
/// In words: what is no whole number of pixels.
fn pixels(what: &str, side: Number) -> Result<u32, String> {
    let whole = side.0 >= 1.0 && side.0 <= 999_999.0 && side.0.fract() == 0.0;
    let pixels = u32::cut(side.0);
    if whole { Ok(pixels) } else { Err(format!("{what} is {}; whole pixels are needed, 1 to 999999", side.0)) }
}
