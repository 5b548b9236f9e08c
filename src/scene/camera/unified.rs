//! The enhanced unified camera model (Khomutenko, Garcia and Martinet, "An Enhanced Unified Camera Model", 2016): a point is
//! put on an ellipsoid, and seen from somewhere on its axis. With d = sqrt(beta (X^2 + Y^2) + Z^2),
//!
//! ```text
//! (x, y) = (X, Y) / (alpha d + (1 - alpha) Z)
//! ```

use glam::{DVec2, DVec3};

/// The parameters of the model.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Unified {
    /// The place of the second projection: 0 (pinhole) to 1.
    pub alpha: f64,
    /// The shape of the ellipsoid, above 0.
    pub beta: f64,
}

impl Unified {
    /// Checks the parameters' ranges.
    ///
    /// # Errors
    /// In words: an alpha outside 0 to 1, a beta that is not above 0.
    pub(super) fn check(self) -> Result<(), String> {
        let Unified { alpha, beta } = self;
        if !(0.0..=1.0).contains(&alpha) {
            return Err(format!("alpha is {alpha}; it must be 0 to 1"));
        }
        if beta <= 0.0 {
            return Err(format!("beta is {beta}; it must be above 0"));
        }
        Ok(())
    }

    /// The unit direction that is seen at a point of the plane.
    pub(super) fn ray(self, at: DVec2) -> Option<DVec3> {
        let Unified { alpha, beta } = self;
        let r2 = at.length_squared();
        let root = 1.0 - (2.0 * alpha - 1.0) * beta * r2;
        // Beyond, no direction leads to the point.
        (root >= 0.0).then(|| {
            let depth = (1.0 - beta * alpha * alpha * r2) / (alpha * root.sqrt() + (1.0 - alpha));
            at.extend(depth).normalize()
        })
    }

    /// The point of the plane where a point in camera coordinates is seen.
    pub(super) fn project(self, point: DVec3) -> Option<DVec2> {
        let Unified { alpha, beta } = self;
        let across = point.truncate();
        let d = (beta * across.length_squared() + point.z * point.z).sqrt();
        let depth = alpha * d + (1.0 - alpha) * point.z;
        // What lies farther back than this would be seen where something else is.
        let back = if alpha <= 0.5 { alpha / (1.0 - alpha) } else { (1.0 - alpha) / alpha };
        (depth > 0.0 && point.z > -back * d).then(|| across / depth)
    }
}
