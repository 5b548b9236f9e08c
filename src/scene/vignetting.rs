//! Vignetting: how much darker a lens is towards its corners.

use glam::{UVec2, Vec2};
use serde::{Deserialize, Serialize};

/// The logarithm of a lens's transmission over that in the middle of the image, `second r^2 + fourth r^4`, where r is the distance
/// from the middle and 1 at the corners.
#[derive(Debug, Clone, Copy, PartialEq, Default, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Vignetting {
    /// The term of the second order.
    pub second: f32,
    /// The term of the fourth order.
    pub fourth: f32,
}

impl Vignetting {
    /// A lens that is as bright all over.
    pub(crate) const NONE: Vignetting = Vignetting { second: 0.0, fourth: 0.0 };

    /// The transmission at a squared distance from the middle.
    pub(crate) fn at(self, radius2: f32) -> f32 {
        if self == Vignetting::NONE { 1.0 } else { ((self.fourth * radius2 + self.second) * radius2).exp() }
    }

    /// The transmission at the middle of a pixel of an image of this size.
    pub(crate) fn at_pixel(self, pixel: UVec2, size: UVec2) -> f32 {
        self.at(radius2(pixel.as_vec2() + 0.5, size))
    }
}

/// The squared distance of a place from the middle of an image of this size.
pub(crate) fn radius2(place: Vec2, size: UVec2) -> f32 {
    let middle = size.as_vec2() / 2.0;
    (place - middle).length_squared() / middle.length_squared().max(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn corners_are_at_one_and_the_middle_is_as_it_is() {
        let size = UVec2::new(40, 30);
        assert!((radius2(Vec2::new(40.0, 0.0), size) - 1.0).abs() < 1e-6);
        let lens = Vignetting { second: -0.2, fourth: -0.1 };
        assert_eq!((lens.at(0.0), Vignetting::NONE.at(1.0)), (1.0, 1.0));
        assert!((lens.at(1.0) - (-0.3f32).exp()).abs() < 1e-6 && (lens.at(0.25) - (-0.05625f32).exp()).abs() < 1e-6);
        assert!(lens.at_pixel(UVec2::ZERO, size) < lens.at_pixel(UVec2::new(20, 15), size));
    }
}
