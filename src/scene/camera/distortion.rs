//! How lenses move points on the plane of unit focal length.

use glam::{DMat2, DVec2};

/// The terms of a lens that move points on the plane: radial, rational, tangential and thin prism. Every term that a
/// lens does not have is 0. With r2 = |q|^2,
///
/// ```text
/// a    = q (1 + k1 r2 + k2 r2^2 + ..) / (1 + d1 r2 + d2 r2^2 + ..)
/// q'   = a + tangential(b) + prism(b)                  b is q; or a, where the terms are chained
/// tangential(b) = (2 p1 x y + p2 (R + 2 x^2), 2 p2 x y + p1 (R + 2 y^2))      (x, y) = b, R = |b|^2
/// prism(b)      = (s1 R + s2 R^2, s3 R + s4 R^2)
/// ```
///
/// p1 and p2 are in OpenCV's order. Source: COLMAP's camera models, `src/colmap/sensor/models.h`; Brown 1966 for the
/// tangential terms.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Distortion {
    /// k1, k2, ..
    pub radial: [f64; 6],
    /// d1, d2, d3.
    pub rational: [f64; 3],
    /// p1, p2.
    pub tangential: [f64; 2],
    /// s1, s2, s3, s4.
    pub prism: [f64; 4],
    /// Whether the tangential and prism terms act on the point that the radial term gives.
    pub chained: bool,
}

/// The series 1 + c1 x + c2 x^2 + .., and its derivative.
fn series(coefficients: &[f64], x: f64) -> (f64, f64) {
    let (value, slope) = coefficients.iter().rev().fold((0.0, 0.0), |(v, d), c| (v * x + c, d * x + v));
    (1.0 + value * x, slope * x + value)
}

impl Distortion {
    /// A distortion of radial terms alone: k1, k2, ..; at most six.
    pub fn radial<const N: usize>(k: [f64; N]) -> Self {
        const { assert!(N <= 6, "there are six radial terms") };
        let radial = std::array::from_fn(|i| k.get(i).copied().unwrap_or(0.0));
        Distortion { radial, ..Distortion::default() }
    }

    /// All terms.
    pub(super) fn terms(&self) -> impl Iterator<Item = f64> {
        let Distortion { radial, rational, tangential, prism, chained: _ } = self;
        radial.iter().chain(rational).chain(tangential).chain(prism).copied()
    }

    /// The factor of the radial term at r2, and its derivative by r2.
    fn factor(&self, r2: f64) -> (f64, f64) {
        let (n, dn) = series(&self.radial, r2);
        let (d, dd) = series(&self.rational, r2);
        (n / d, (dn * d - n * dd) / (d * d))
    }

    /// The radius that the radial term gives a point at radius `r`, and its derivative by `r`.
    pub(crate) fn outward(&self, r: f64) -> (f64, f64) {
        let (factor, slope) = self.factor(r * r);
        (r * factor, factor + 2.0 * r * r * slope)
    }

    /// The moved point, and its derivative by the point.
    pub(super) fn apply(&self, q: DVec2) -> (DVec2, DMat2) {
        let (factor, slope) = self.factor(q.length_squared());
        let radial = q * factor;
        let outer = DMat2::from_cols(q * q.x, q * q.y);
        let by_radial = DMat2::from_diagonal(DVec2::splat(factor)) + outer * (2.0 * slope);
        let (added, by_added) = self.beside(if self.chained { radial } else { q });
        let by_added = if self.chained { by_added * by_radial } else { by_added };
        (radial + added, by_radial + by_added)
    }

    /// The sum of the tangential and prism terms, and its derivative.
    fn beside(&self, b: DVec2) -> (DVec2, DMat2) {
        let ([p1, p2], [s1, s2, s3, s4]) = (self.tangential, self.prism);
        let (x, y, r2) = (b.x, b.y, b.length_squared());
        let value = DVec2::new(
            2.0 * p1 * x * y + p2 * (r2 + 2.0 * x * x) + (s1 + s2 * r2) * r2,
            2.0 * p2 * x * y + p1 * (r2 + 2.0 * y * y) + (s3 + s4 * r2) * r2,
        );
        // The derivative of the prism terms by r2; that of r2 follows below.
        let prism = DVec2::new(s1 + 2.0 * s2 * r2, s3 + 2.0 * s4 * r2);
        let by_x = DVec2::new(2.0 * p1 * y + 6.0 * p2 * x, 2.0 * p2 * y + 2.0 * p1 * x) + prism * (2.0 * x);
        let by_y = DVec2::new(2.0 * p1 * x + 2.0 * p2 * y, 2.0 * p2 * x + 6.0 * p1 * y) + prism * (2.0 * y);
        (value, DMat2::from_cols(by_x, by_y))
    }
}

/// An omega below this counts as 0, where the model has a limit: no distortion.
const NARROW: f64 = 1e-6;

/// The field-of-view model: r' = atan(2 r tan(omega / 2)) / omega.
pub(super) fn field_of_view(omega: f64, q: DVec2) -> DVec2 {
    let r = q.length();
    if r == 0.0 || omega < NARROW {
        return q;
    }
    q * ((2.0 * r * (0.5 * omega).tan()).atan() / (r * omega))
}

/// The inverse of [`field_of_view`]; `None` beyond the points at infinity.
pub(super) fn undo_field_of_view(omega: f64, at: DVec2) -> Option<DVec2> {
    let r = at.length();
    if r == 0.0 || omega < NARROW {
        return Some(at);
    }
    let angle = r * omega;
    (angle < std::f64::consts::FRAC_PI_2).then(|| at * (angle.tan() / (2.0 * r * (0.5 * omega).tan())))
}
