//! A lens: how directions become pixels.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};

use super::distortion::{self, Distortion};
use super::reach::Reach;
use super::unified::Unified;

/// The largest parameter: rays overflow beyond it.
const LARGEST: f64 = 1e9;

/// The farthest point that a perspective lens sees on its plane: 89.99 degrees off the axis.
const FARTHEST: f64 = 5729.6;

/// A lens: focal lengths, principal point, and projection.
#[derive(Debug, Clone, PartialEq)]
pub struct Lens {
    focal: DVec2,
    centre: DVec2,
    projection: Projection,
    reach: Reach,
}

/// How a direction (X, Y, Z) becomes a point on the plane of unit focal length.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum Projection {
    /// (X, Y) / Z.
    Pinhole,
    /// (X, Y) / Z, then moved by the distortion.
    Perspective(Distortion),
    /// The angle to the axis, along (X, Y), then moved by the distortion: a fisheye.
    Equidistant(Distortion),
    /// The distortion says the way back: it moves a point of the image to (X, Y) / Z.
    Inward(Distortion),
    /// The field-of-view model of Devernay and Faugeras (2001).
    FieldOfView {
        /// The model's angle, radians: 0 to pi.
        omega: f64,
    },
    /// The enhanced unified model of Khomutenko, Garcia and Martinet (2016).
    Unified(Unified),
}

impl Projection {
    /// The first parameter that is not finite or too large.
    fn beyond(&self) -> Option<f64> {
        let wrong = |p: &f64| !within(*p);
        match self {
            Projection::Pinhole => None,
            Projection::Perspective(d) | Projection::Equidistant(d) | Projection::Inward(d) => d.terms().find(wrong),
            Projection::FieldOfView { omega } => Some(*omega).filter(wrong),
            Projection::Unified(Unified { alpha, beta }) => [*alpha, *beta].into_iter().find(wrong),
        }
    }
}

fn within(parameter: f64) -> bool {
    parameter.abs() <= LARGEST
}

impl Lens {
    /// A lens of focal lengths `focal` and principal point `centre`, both in pixels. A lens whose pixels are square has
    /// the same focal length twice.
    ///
    /// # Errors
    /// In words: a parameter that is not finite or beyond 1e9, a focal length that is not above 0, an omega outside 0
    /// to pi, an alpha or a beta that is none.
    pub fn new(focal: DVec2, centre: DVec2, projection: Projection) -> Result<Lens, String> {
        let pixels = [focal.x, focal.y, centre.x, centre.y];
        if let Some(bad) = pixels.into_iter().find(|p| !within(*p)).or_else(|| projection.beyond()) {
            return Err(format!("a parameter is {bad}; it must be finite and at most {LARGEST:e}"));
        }
        if focal.min_element() <= 0.0 {
            return Err(format!("a focal length is {}; it must be above 0", focal.min_element()));
        }
        if let Projection::FieldOfView { omega } = projection
            && !(0.0..PI).contains(&omega)
        {
            return Err(format!("omega is {omega}; it must be at least 0 and below pi"));
        }
        if let Projection::Unified(unified) = projection {
            unified.check()?;
        }
        Ok(Lens { focal, centre, projection, reach: reach(&projection) })
    }

    /// A lens without distortion, of values that the program itself makes. Values of a file go through [`Lens::new`],
    /// which checks them.
    pub fn pinhole(focal: DVec2, centre: DVec2) -> Lens {
        let projection = Projection::Pinhole;
        Lens { focal, centre, projection, reach: reach(&projection) }
    }

    /// The focal lengths, pixels.
    pub fn focal(&self) -> DVec2 {
        self.focal
    }

    /// The principal point, pixels.
    pub fn centre(&self) -> DVec2 {
        self.centre
    }

    /// The projection.
    pub fn projection(&self) -> &Projection {
        &self.projection
    }

    /// The lens for an image whose sides are `scale` times as long.
    pub(super) fn scaled(&self, scale: DVec2) -> Lens {
        Lens { focal: self.focal * scale, centre: self.centre * scale, ..self.clone() }
    }

    /// The unit direction that is seen at `pixel`.
    #[inline]
    pub(super) fn ray(&self, pixel: DVec2) -> Option<DVec3> {
        let at = (pixel - self.centre) / self.focal;
        match &self.projection {
            Projection::Pinhole => Some(at.extend(1.0).normalize()),
            Projection::Perspective(d) => self.reach.undo(d, at).map(|q| q.extend(1.0).normalize()),
            Projection::Equidistant(d) => self.reach.undo(d, at).map(|q| {
                let angle = q.length();
                let (sin, cos) = angle.sin_cos();
                let across = if angle > 0.0 { q * (sin / angle) } else { DVec2::ZERO };
                across.extend(cos)
            }),
            Projection::Inward(d) => self.reach.apply(d, at).map(|q| q.extend(1.0).normalize()),
            Projection::Unified(unified) => unified.ray(at),
            Projection::FieldOfView { omega } => {
                distortion::undo_field_of_view(*omega, at).map(|q| q.extend(1.0).normalize())
            }
        }
    }

    /// The pixel where a point is seen.
    #[inline]
    pub(super) fn project(&self, point: DVec3) -> Option<DVec2> {
        let flat = || (point.z > 0.0).then(|| point.truncate() / point.z);
        let moved = match &self.projection {
            Projection::Pinhole => flat(),
            Projection::Perspective(d) => flat().and_then(|q| self.reach.apply(d, q)),
            Projection::Equidistant(d) => {
                let (across, length) = (point.truncate(), point.truncate().length());
                let angle = length.atan2(point.z);
                // A point straight behind has no direction on the plane.
                let seen = length > 0.0 || point.z > 0.0;
                seen.then(|| if length > 0.0 { across * (angle / length) } else { DVec2::ZERO })
                    .and_then(|q| self.reach.apply(d, q))
            }
            Projection::Inward(d) => flat().and_then(|q| self.reach.undo(d, q)),
            Projection::Unified(unified) => unified.project(point),
            Projection::FieldOfView { omega } => flat().map(|q| distortion::field_of_view(*omega, q)),
        };
        moved.map(|at| self.focal * at + self.centre)
    }
}

/// How far out a projection's distortion can be undone.
fn reach(projection: &Projection) -> Reach {
    match projection {
        Projection::Perspective(d) | Projection::Inward(d) => Reach::of(d, FARTHEST),
        Projection::Equidistant(d) => Reach::of(d, PI),
        Projection::Pinhole | Projection::FieldOfView { .. } | Projection::Unified(_) => Reach::default(),
    }
}
