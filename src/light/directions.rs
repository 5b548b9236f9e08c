//! Directions: spread over a hemisphere, in rings about one of them, and turned about up.

use std::f32::consts::TAU;

use glam::{Mat3, Quat, Vec3};

use crate::base::convert::to_f32;

/// Two axes across `z` and `z` itself, a unit vector.
fn axes(z: Vec3) -> Mat3 {
    let (x, y) = z.any_orthonormal_pair();
    Mat3::from_cols(x, y, z)
}

/// `count` unit vectors from the lowest elevation about `up` to the zenith, evenly spread (Fibonacci's spiral).
pub(super) fn dome(up: Vec3, count: usize, lowest_degrees: f64) -> Vec<Vec3> {
    let (axes, low) = (axes(up), lowest_degrees.to_radians().sin());
    let golden = std::f64::consts::PI * (1.0 + 5f64.sqrt());
    let direction = |k: usize| {
        let at = k as f64 + 0.5;
        let z = 1.0 - at / count as f64 * (1.0 - low);
        let (across, (sin, cos)) = ((1.0 - z * z).max(0.0).sqrt(), (golden * at).sin_cos());
        axes * Vec3::new(to_f32(across * cos), to_f32(across * sin), to_f32(z))
    };
    (0..count).map(direction).collect()
}

/// The direction itself, then `rings` rings of unit vectors about it, `step_degrees` apart.
pub(super) fn rings(middle: Vec3, step_degrees: f32, rings: usize) -> Vec<Vec3> {
    let axes = axes(middle);
    let ring = |ring: usize| {
        let (sin, cos) = (step_degrees * ring as f32).to_radians().sin_cos();
        (0..6 * ring).map(move |k| {
            let (across, along) = (TAU * k as f32 / (6 * ring) as f32).sin_cos();
            (axes * Vec3::new(sin * along, sin * across, cos)).normalize()
        })
    };
    std::iter::once(middle).chain((1..=rings).flat_map(ring)).collect()
}

/// The direction turned about `up`.
pub(super) fn turned(direction: Vec3, up: Vec3, degrees: f32) -> Vec3 {
    Quat::from_axis_angle(up, degrees.to_radians()) * direction
}

/// The angle between two unit vectors, degrees.
pub(super) fn angle(a: Vec3, b: Vec3) -> f32 {
    // The cross product keeps small angles exact.
    a.cross(b).length().atan2(a.dot(b)).to_degrees()
}

/// The angle of a unit vector above the plane across `up`, degrees.
pub(super) fn elevation(direction: Vec3, up: Vec3) -> f32 {
    direction.dot(up).clamp(-1.0, 1.0).asin().to_degrees()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_dome_is_even_and_above_its_lowest_elevation() {
        let up = Vec3::new(1.0, 2.0, -3.0).normalize();
        let dome = dome(up, 400, 8.0);
        assert!(dome.iter().all(|d| d.is_normalized() && elevation(*d, up) > 7.9));
        let nearest = |d: Vec3| dome.iter().filter(|e| **e != d).map(|e| angle(d, *e)).fold(f32::MAX, f32::min);
        assert!(dome.iter().all(|d| (4.0..9.0).contains(&nearest(*d))));
    }

    #[test]
    fn rings_lie_at_their_distance() {
        let middle = Vec3::new(0.3, -0.5, 0.8).normalize();
        let all = rings(middle, 2.0, 2);
        let at: Vec<f32> = all.iter().map(|d| angle(*d, middle).round()).collect();
        assert_eq!(at, [vec![0.0], vec![2.0; 6], vec![4.0; 12]].concat());
        assert!((angle(turned(middle, Vec3::Z, 180.0), turned(middle, Vec3::Z, 90.0)) - 60.0).abs() < 40.0);
        assert!((elevation(turned(middle, Vec3::Z, 77.0), Vec3::Z) - elevation(middle, Vec3::Z)).abs() < 1e-4);
    }
}
