//! Back through a distortion.

use glam::DVec2;

use super::distortion::Polynomial;

/// A distortion that can be undone within its reach: from the middle out to where its radial part stops growing. Beyond,
/// the lens folds: points out there are seen nowhere, or where others are seen too.
#[derive(Debug, Clone, PartialEq)]
pub struct Inverse {
    distortion: Polynomial,
    /// How far from the middle it can be undone, before distortion.
    reach: f64,
    /// How far out `reach` is put.
    edge: f64,
}

/// Steps of Newton's method. Real lenses take three to five.
const STEPS: usize = 30;

/// A residue, in focal lengths, that counts as none: a millionth of a pixel, where a pixel is a ten-thousandth.
const EXACT: f64 = 1e-13;

/// Ratio of neighbouring radii that are tried for the reach, and the first of them.
const RATIO: f64 = 1.002;
const FIRST: f64 = 1e-3;

impl Inverse {
    /// Finds the reach of a distortion, up to `most`.
    pub fn new(distortion: Polynomial, most: f64) -> Self {
        let radii = std::iter::successors(Some(FIRST), |r| Some(r * RATIO)).take_while(|r| *r < most);
        let grows = |r: &f64| distortion.radial(*r).1 > 0.0 && distortion.radial(*r).0.is_finite();
        // The first radius that does not grow is left out.
        let reach = radii.chain([most]).take_while(grows).last().unwrap_or(0.0);
        let edge = distortion.radial(reach).0;
        Inverse { distortion, reach, edge }
    }

    /// What is undone.
    #[cfg(test)]
    pub fn distortion(&self) -> &Polynomial {
        &self.distortion
    }

    /// The moved point; `None` out of reach.
    pub fn apply(&self, q: DVec2) -> Option<DVec2> {
        (q.length() <= self.reach).then(|| self.distortion.apply(q).0)
    }

    /// The point that is moved to `at`; `None` if none within reach is.
    #[inline]
    pub fn undo(&self, at: DVec2) -> Option<DVec2> {
        // From where the point is seen, nearly all lenses converge; where not, from where the radial part alone puts it.
        self.newton(at, at).or_else(|| self.newton(self.undo_radial(at)?, at))
    }

    fn newton(&self, start: DVec2, at: DVec2) -> Option<DVec2> {
        let mut q = start;
        for _ in 0..STEPS {
            let (moved, by_q) = self.distortion.apply(q);
            let residue = moved - at;
            if residue.abs().max_element() <= EXACT * (1.0 + at.abs().max_element()) {
                // A root where the plane is turned over is not the first one.
                return (by_q.determinant() > 0.0 && q.length() <= self.reach).then_some(q);
            }
            q -= by_q.inverse() * residue;
            if !q.is_finite() {
                return None;
            }
            // What leaves the reach is taken back to its edge.
            q = q.clamp_length_max(self.reach);
        }
        None
    }

    /// Back through the radial part alone, by bisection.
    fn undo_radial(&self, at: DVec2) -> Option<DVec2> {
        let wanted = at.length();
        if wanted == 0.0 {
            return Some(at);
        }
        let (mut low, mut high) = (0.0, self.reach);
        for _ in 0..60 {
            let middle = 0.5 * (low + high);
            *(if self.distortion.radial(middle).0 < wanted.min(self.edge) { &mut low } else { &mut high }) = middle;
        }
        Some(at * (low / wanted))
    }
}
