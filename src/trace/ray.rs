//! Rays and their hits.

use glam::Vec3;

use crate::base::convert::to_f32;
use crate::base::ids::TriangleId;

/// A half-line. One with a component that is not finite, or without a direction, meets nothing; nor does one that starts
/// 2^96 times farther away than the scene is large.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ray {
    /// Where the ray starts, relative to the mesh's origin.
    pub origin: Vec3,
    /// Where the ray goes; its length is the unit of distances along the ray.
    pub direction: Vec3,
}

impl Ray {
    /// The point at distance `t`.
    pub fn at(&self, t: f32) -> Vec3 {
        self.origin + self.direction * t
    }
}

/// The nearest triangle along a ray.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Hit {
    /// The triangle; [`TriangleId::NONE`] if there is none.
    pub triangle: TriangleId,
    /// Distance, in lengths of the ray's direction; above 0. Infinite if nothing was hit.
    pub t: f32,
    /// Barycentric weight of the triangle's vertex 1, in [0, 1].
    pub u: f32,
    /// Barycentric weight of vertex 2; that of vertex 0 is `1 - u - v`.
    pub v: f32,
}

impl Hit {
    /// The hit of a ray that meets nothing.
    pub const MISS: Hit = Hit { triangle: TriangleId::NONE, t: f32::INFINITY, u: 0.0, v: 0.0 };

    /// Whether a triangle was hit.
    pub fn is_some(&self) -> bool {
        self.triangle != TriangleId::NONE
    }
}

/// A prepared direction: scaled by a power of two so that its largest component lies in [1/2, 1), and sheared so that
/// it runs along one axis (Woop, Benthin and Wald, "Watertight Ray/Triangle Intersection", JCGT 2(1), 2013, section 3.1).
#[derive(Debug, Clone, Copy)]
pub(super) struct Course {
    /// Axes in the order x, y, z of the sheared space: z is the direction's largest, the others follow in cyclic order.
    pub axes: [usize; 3],
    /// Which components are negative, -0 included: bit i for axis i.
    pub signs: u8,
    /// Reciprocals of the scaled components; infinite where one is 0.
    pub inverse: [f32; 3],
    /// The shear of x and y by z, in [-1, 1].
    pub shear: [f32; 2],
    /// The scaled direction's largest component.
    pub depth: f32,
    /// A unit of distance along the scaled direction, in lengths of the given direction, in the same space.
    pub unit: f64,
}

impl Course {
    /// A course that fills arrays before they are set.
    pub(super) const NOWHERE: Course =
        Course { axes: [0; 3], signs: 0, inverse: [0.0; 3], shear: [0.0; 2], depth: 0.0, unit: 0.0 };

    /// `None` if the direction is zero or not finite.
    #[inline]
    pub(super) fn new(direction: Vec3) -> Option<Course> {
        let d = direction.to_array();
        let size = d.map(f32::abs);
        let z = if size[0] >= size[1] && size[0] >= size[2] { 0 } else { 1 + usize::from(size[2] > size[1]) };
        if !direction.is_finite() || size[z] == 0.0 {
            return None;
        }
        let unit = scale_below_one(size[z]);
        let d = d.map(|c| to_f32(f64::from(c) * unit));
        let axes = [(z + 1) % 3, (z + 2) % 3, z];
        Some(Course {
            axes,
            signs: (0..3).fold(0, |bits, i| bits | u8::from(d[i].is_sign_negative()) << i),
            inverse: d.map(|c| 1.0 / c),
            shear: [d[axes[0]] / d[z], d[axes[1]] / d[z]],
            depth: d[z],
            unit,
        })
    }
}

/// The power of two that brings `size`, finite and above 0, into [1/2, 1).
#[inline]
pub(super) fn scale_below_one(size: f32) -> f64 {
    // The exponent of an f64 that was an f32 is never subnormal, and its negative is in range.
    let exponent = (f64::from(size).to_bits() >> 52) as i64 - 1023;
    f64::from_bits(((1023 - exponent - 1) as u64) << 52)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn scales_are_powers_of_two_into_the_upper_half() {
        for size in [1.0, 0.5, 0.75, 3.0, f32::MAX, f32::MIN_POSITIVE, f32::from_bits(1)] {
            let s = scale_below_one(size);
            let scaled = f64::from(size) * s;
            assert!((0.5..1.0).contains(&scaled), "{size:e} became {scaled}");
            assert_eq!(s.to_bits() << 12, 0, "{s:e} is no power of two");
        }
    }

    #[test]
    fn no_direction_no_course() {
        for d in [Vec3::ZERO, Vec3::NAN, Vec3::new(1.0, f32::INFINITY, 0.0), Vec3::new(f32::NAN, 1.0, 0.0)] {
            assert!(Course::new(d).is_none(), "{d}");
        }
        let course = Course::new(Vec3::new(0.0, -0.0, -8.0)).unwrap();
        assert_eq!((course.axes, course.signs, course.depth, course.unit), ([0, 1, 2], 0b110, -0.5, 0.0625));
    }
}
