//! Undoing a distortion.

use glam::DVec2;

use super::distortion::Distortion;

/// How far a distortion can be undone: from the middle out to the radius where its radial part stops growing. The lens
/// folds there: a point beyond is seen nowhere, or where another point is seen too.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Reach {
    /// The radius, before distortion.
    radius: f64,
    /// The same radius after distortion.
    edge: f64,
}

/// The most steps of Newton's method. Real lenses take three to five.
const STEPS: usize = 30;

/// The largest residue that counts as none, in focal lengths: a millionth of a pixel that is a ten-thousandth wide.
const EXACT: f64 = 1e-13;

/// The ratio of neighbouring radii that are tried, and the first radius.
const RATIO: f64 = 1.002;
const FIRST: f64 = 1e-3;

impl Reach {
    /// The reach of a distortion, up to the radius `most`.
    pub(super) fn of(distortion: &Distortion, most: f64) -> Self {
        let radii = std::iter::successors(Some(FIRST), |r| Some(r * RATIO)).take_while(|r| *r < most);
        // Beyond a pole of the rational terms, the radius grows again from below 0.
        let grows = |r: &f64| {
            let (outward, slope) = distortion.outward(*r);
            slope > 0.0 && outward > 0.0 && outward.is_finite()
        };
        let radius = radii.chain([most]).take_while(grows).last().unwrap_or(0.0);
        let edge = distortion.outward(radius).0;
        Reach { radius, edge }
    }

    /// The moved point; `None` out of reach.
    pub(super) fn apply(&self, distortion: &Distortion, q: DVec2) -> Option<DVec2> {
        (q.length() <= self.radius).then(|| distortion.apply(q).0)
    }

    /// The point that is moved to `at`; `None` if no point within reach is.
    #[inline]
    pub(super) fn undo(&self, distortion: &Distortion, at: DVec2) -> Option<DVec2> {
        // Nearly all lenses converge from `at` itself; the others from where the radial part alone puts the point.
        self.newton(distortion, at, at).or_else(|| self.newton(distortion, self.undo_radial(distortion, at)?, at))
    }

    fn newton(&self, distortion: &Distortion, start: DVec2, at: DVec2) -> Option<DVec2> {
        let mut q = start;
        for _ in 0..STEPS {
            let (moved, by_q) = distortion.apply(q);
            let residue = moved - at;
            if residue.abs().max_element() <= EXACT * (1.0 + at.abs().max_element()) {
                // Where the plane is turned over, the root is not the first one.
                return (by_q.determinant() > 0.0 && q.length() <= self.radius).then_some(q);
            }
            q -= by_q.inverse() * residue;
            if !q.is_finite() {
                return None;
            }
            // A point that leaves the reach goes back to its edge.
            q = q.clamp_length_max(self.radius);
        }
        None
    }

    /// Undoes the radial part alone, by bisection.
    fn undo_radial(&self, distortion: &Distortion, at: DVec2) -> Option<DVec2> {
        let wanted = at.length();
        if wanted == 0.0 {
            return Some(at);
        }
        let (mut low, mut high) = (0.0, self.radius);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if distortion.outward(middle).0 < wanted.min(self.edge) { &mut low } else { &mut high }) = middle;
        }
        Some(at * (low / wanted))
    }
}
