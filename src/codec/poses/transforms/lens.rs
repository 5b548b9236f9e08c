//! The lens of a frame: what the file says for all frames, and what the frame says of itself.

use glam::DVec2;
use serde::Deserialize;
use serde::de::IgnoredAny;

use crate::base::convert::Cut;
use crate::base::shown::shown;
use crate::codec::images::Size;
use crate::codec::poses::json::Number;
use crate::codec::poses::terms;
use crate::scene::camera::{Camera, Distortion, Lens, Projection};

/// The keys of a lens.
#[derive(Debug, Clone, Default, PartialEq, Deserialize)]
pub(super) struct Intrinsics {
    camera_model: Option<String>,
    is_fisheye: Option<bool>,
    camera_angle_x: Option<Number>,
    camera_angle_y: Option<Number>,
    fl_x: Option<Number>,
    fl_y: Option<Number>,
    cx: Option<Number>,
    cy: Option<Number>,
    w: Option<Number>,
    h: Option<Number>,
    k1: Option<Number>,
    k2: Option<Number>,
    k3: Option<Number>,
    k4: Option<Number>,
    k5: Option<Number>,
    k6: Option<Number>,
    p1: Option<Number>,
    p2: Option<Number>,
    /// The terms of NVIDIA's f-theta lenses begin with this one.
    ftheta_p0: Option<IgnoredAny>,
    latlong: Option<Flag>,
    is_latlong: Option<Flag>,
    equirectangular: Option<Flag>,
    orthographic: Option<Flag>,
}

/// A flag, written as true and false or as numbers.
#[derive(Debug, Clone, Copy, PartialEq, Deserialize)]
#[serde(untagged)]
enum Flag {
    Is(bool),
    Number(f64),
}

impl Flag {
    fn is_set(self) -> bool {
        matches!(self, Flag::Is(true)) || matches!(self, Flag::Number(n) if n != 0.0)
    }
}

impl Intrinsics {
    /// These keys, with those of a frame over them.
    pub(super) fn overlaid(&self, own: &Intrinsics) -> Intrinsics {
        let model = || own.camera_model.clone().or_else(|| self.camera_model.clone());
        Intrinsics {
            camera_model: model(),
            is_fisheye: own.is_fisheye.or(self.is_fisheye),
            camera_angle_x: own.camera_angle_x.or(self.camera_angle_x),
            camera_angle_y: own.camera_angle_y.or(self.camera_angle_y),
            fl_x: own.fl_x.or(self.fl_x),
            fl_y: own.fl_y.or(self.fl_y),
            cx: own.cx.or(self.cx),
            cy: own.cy.or(self.cy),
            w: own.w.or(self.w),
            h: own.h.or(self.h),
            k1: own.k1.or(self.k1),
            k2: own.k2.or(self.k2),
            k3: own.k3.or(self.k3),
            k4: own.k4.or(self.k4),
            k5: own.k5.or(self.k5),
            k6: own.k6.or(self.k6),
            p1: own.p1.or(self.p1),
            p2: own.p2.or(self.p2),
            ftheta_p0: own.ftheta_p0.or(self.ftheta_p0),
            latlong: own.latlong.or(self.latlong),
            is_latlong: own.is_latlong.or(self.is_latlong),
            equirectangular: own.equirectangular.or(self.equirectangular),
            orthographic: own.orthographic.or(self.orthographic),
        }
    }

    /// The size of the image, if the file says it.
    ///
    /// # Errors
    /// In words: a side that is not a whole number of pixels.
    pub(super) fn size(&self) -> Result<Option<Size>, String> {
        let side = |name: &str, value: Number| {
            let whole = value.0 >= 1.0 && value.0 <= 999_999.0 && value.0.fract() == 0.0;
            let pixels = u32::cut(value.0);
            if whole { Ok(pixels) } else { Err(format!("{name} is {}; whole pixels are needed, 1 to 999999", value.0)) }
        };
        let (Some(w), Some(h)) = (self.w, self.h) else { return Ok(None) };
        Ok(Some(Size { width: side("w", w)?, height: side("h", h)? }))
    }

    /// Sets the size that the image has.
    pub(super) fn set_size(&mut self, size: Size) {
        (self.w, self.h) = (Some(Number(size.width.into())), Some(Number(size.height.into())));
    }

    /// What the file says twice and differently.
    pub(super) fn contradiction(&self) -> Option<String> {
        let (Some(angle), Some(w), Some(fl_x)) = (self.camera_angle_x, self.w, self.fl_x) else { return None };
        let by_focal = 2.0 * (w.0 / (2.0 * fl_x.0)).atan();
        ((by_focal - angle.0).abs() > 1e-3).then(|| {
            format!(
                "camera_angle_x is {:.6}, but w and fl_x say {by_focal:.6}: fl_x is taken; look which is right",
                angle.0
            )
        })
    }

    /// The camera; the size must be set.
    ///
    /// # Errors
    /// In words: no focal length, a model that is no lens, a parameter out of range.
    pub(super) fn camera(&self) -> Result<Camera, String> {
        let size = self.size()?.ok_or("w and h are needed")?;
        let sides = DVec2::new(size.width.into(), size.height.into());
        let by_angle = |side: f64, angle: Option<Number>| angle.map(|angle| 0.5 * side / (0.5 * angle.0).tan());
        let along = |given: Option<Number>, side, angle| given.map(|value| value.0).or_else(|| by_angle(side, angle));
        let x = along(self.fl_x, sides.x, self.camera_angle_x);
        let y = along(self.fl_y, sides.y, if self.fl_x.is_some() { None } else { self.camera_angle_y });
        let (Some(x), Some(y)) = (x.or(y), y.or(x)) else {
            return Err("it has no focal length: fl_x or camera_angle_x is needed".to_owned());
        };
        let centre =
            DVec2::new(self.cx.map_or(0.5 * sides.x, |value| value.0), self.cy.map_or(0.5 * sides.y, |value| value.0));
        let lens = Lens::new(DVec2::new(x, y), centre, self.projection()?)?;
        Camera::new(size.width.into(), size.height.into(), lens)
    }

    /// The other kind of lens that keys beside the model's say, as instant-ngp has it.
    fn other_kind(&self) -> Option<&'static str> {
        let set = |flag: Option<Flag>| flag.is_some_and(Flag::is_set);
        let kinds = [
            (self.ftheta_p0.is_some(), "ftheta_p0"),
            (set(self.latlong), "latlong"),
            (set(self.is_latlong), "is_latlong"),
            (set(self.equirectangular), "equirectangular"),
            (set(self.orthographic), "orthographic"),
        ];
        kinds.into_iter().find(|(is, _)| *is).map(|(_, key)| key)
    }

    fn projection(&self) -> Result<Projection, String> {
        if let Some(key) = self.other_kind() {
            let advice = "undistort the photographs to perspective ones";
            return Err(format!("it has {key}, and no lens of gonio is of that kind: {advice}"));
        }
        terms::none("k5", self.k5.unwrap_or_default().0)?;
        terms::none("k6", self.k6.unwrap_or_default().0)?;
        let k = [self.k1, self.k2, self.k3, self.k4].map(|k| k.unwrap_or_default().0);
        let tangential = [self.p1, self.p2].map(|p| p.unwrap_or_default().0);
        let fisheye = self.is_fisheye.unwrap_or_default();
        match self.camera_model.as_deref().unwrap_or(if fisheye { "OPENCV_FISHEYE" } else { "OPENCV" }) {
            "OPENCV_FISHEYE" | "SIMPLE_RADIAL_FISHEYE" | "RADIAL_FISHEYE" | "SIMPLE_FISHEYE" | "FISHEYE" => {
                Ok(Projection::Equidistant(Distortion::radial(k)))
            }
            "OPENCV" | "PINHOLE" | "SIMPLE_PINHOLE" | "SIMPLE_RADIAL" | "RADIAL" | "PERSPECTIVE" => {
                Ok(Projection::Perspective(Distortion { tangential, ..Distortion::radial(k) }))
            }
            other => Err(format!("its camera_model is {}; OPENCV, OPENCV_FISHEYE and PINHOLE are read", shown(other))),
        }
    }
}
