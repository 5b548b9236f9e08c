//! A camera of OpenSfM: pixels are counted from the centre of the image, in units of its larger side, so that
//! `c_x m + width / 2` is the principal point.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::DVec2;
use serde::Deserialize;

use crate::base::shown::shown;
use crate::scene::camera::{Camera, Distortion, Lens, Projection};

/// A camera as the file has it. A term that is not there is 0.
#[derive(Debug, Clone, Default, Deserialize)]
#[serde(default)]
pub(in crate::codec::poses) struct LensOf {
    /// Files of old versions do not say: perspective.
    projection_type: Option<String>,
    width: u64,
    height: u64,
    focal: f64,
    focal_x: f64,
    focal_y: f64,
    c_x: f64,
    c_y: f64,
    k1: f64,
    k2: f64,
    k3: f64,
    k4: f64,
    k5: f64,
    k6: f64,
    p1: f64,
    p2: f64,
    s0: f64,
    s1: f64,
    s2: f64,
    s3: f64,
}

/// The projections that are lenses.
const KNOWN: &str = "perspective, simple_radial, radial, brown, fisheye, fisheye_opencv, fisheye62, fisheye624";

impl LensOf {
    /// Whether the camera's images have this size.
    pub(in crate::codec::poses) fn is_of(&self, width: u64, height: u64) -> bool {
        (self.width, self.height) == (width, height)
    }

    /// The focal length along the width, in units of the larger side.
    pub(in crate::codec::poses) fn focal(&self) -> f64 {
        if self.focal_x == 0.0 { self.focal } else { self.focal_x }
    }

    /// The camera.
    ///
    /// # Errors
    /// In words: a projection that is no lens, a parameter or a size out of range.
    fn camera(&self) -> Result<Camera, String> {
        let side = |pixels: u64| u32::try_from(pixels).map_err(|_| format!("the image has a side of {pixels} pixels"));
        let size = DVec2::new(side(self.width)?.into(), side(self.height)?.into());
        let unit = size.max_element();
        let focal = DVec2::new(self.focal_x, self.focal_y);
        // One focal length, or one along each side.
        let focal = if focal == DVec2::ZERO { DVec2::splat(self.focal) } else { focal };
        let centre = DVec2::new(self.c_x, self.c_y) * unit + size * 0.5;
        let lens = Lens::new(focal * unit, centre, self.projection()?)?;
        Camera::new(self.width, self.height, lens)
    }

    fn projection(&self) -> Result<Projection, String> {
        let LensOf { k1, k2, k3, k4, k5, k6, p1, p2, .. } = *self;
        let tangential = [p1, p2];
        Ok(match self.projection_type.as_deref().unwrap_or("perspective") {
            "perspective" | "radial" => Projection::Perspective(Distortion::radial([k1, k2])),
            "simple_radial" => Projection::Perspective(Distortion::radial([k1])),
            "brown" => Projection::Perspective(Distortion { tangential, ..Distortion::radial([k1, k2, k3]) }),
            "fisheye" => Projection::Equidistant(Distortion::radial([k1, k2])),
            "fisheye_opencv" => Projection::Equidistant(Distortion::radial([k1, k2, k3, k4])),
            "fisheye62" | "fisheye624" => Projection::Equidistant(Distortion {
                tangential,
                prism: [self.s0, self.s1, self.s2, self.s3],
                ..Distortion::radial([k1, k2, k3, k4, k5, k6])
            }),
            other => return Err(format!("the projection {} is not read; these lenses are: {KNOWN}", shown(other))),
        })
    }
}

/// The cameras of a file by their ids. A camera that no image uses need not be a lens.
#[derive(Debug)]
pub(in crate::codec::poses) struct Lenses<'a> {
    written: &'a BTreeMap<String, LensOf>,
    made: BTreeMap<&'a str, Arc<Camera>>,
}

impl<'a> Lenses<'a> {
    /// The cameras that a file holds.
    pub(in crate::codec::poses) fn of(written: &'a BTreeMap<String, LensOf>) -> Self {
        Lenses { written, made: BTreeMap::new() }
    }

    /// The camera of an image.
    ///
    /// # Errors
    /// In words: an id that no camera has, a camera that is no lens.
    pub(in crate::codec::poses) fn get(&mut self, id: &str) -> Result<Arc<Camera>, String> {
        let found = self.written.get_key_value(id);
        let (id, lens) = found.ok_or_else(|| format!("its camera {} is not among the cameras", shown(id)))?;
        if let Some(made) = self.made.get(id.as_str()) {
            return Ok(Arc::clone(made));
        }
        let made = Arc::new(lens.camera().map_err(|why| format!("its camera {}: {why}", shown(id)))?);
        self.made.insert(id, Arc::clone(&made));
        Ok(made)
    }
}
