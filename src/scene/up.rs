//! The way up, as cameras tell it: people hold a camera level, and fly at one height.

use glam::{DMat3, DVec3};

use super::frame::Frame;

/// The way up that cameras tell.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Upright {
    /// The way up in the coordinates of the poses, of a length of about 1: each component is a multiple of 1/128, so that a frame
    /// more seldom moves it.
    pub up: [f64; 3],
    /// How far the cameras' rows of pixels lean from the horizontal, root mean square, degrees.
    pub leans: f64,
    /// Whether no other direction would do nearly as well.
    pub sure: bool,
}

/// How much the flatness of the flight counts beside how level the cameras are: it decides where all rows of pixels are parallel.
const FLATNESS: f64 = 0.05;

/// Steps of each component.
const STEPS: f64 = 128.0;

impl Upright {
    /// The direction that is the most nearly perpendicular to all rows of pixels and to the flight; on the side that the tops of
    /// the photographs and the backs of the cameras are on. `None` without cameras.
    pub fn of(frames: &[Frame]) -> Option<Upright> {
        let count = frames.len() as f64;
        let centres = || frames.iter().map(|frame| frame.pose.centre());
        let middle = centres().sum::<DVec3>() / count;
        let outer = |v: DVec3| DMat3::from_cols(v * v.x, v * v.y, v * v.z);
        let sum = |all: DMat3, one: DMat3| all + one;
        let rows = frames.iter().map(|frame| outer(frame.pose.rotation.inverse() * DVec3::X)).fold(DMat3::ZERO, sum);
        let flight = centres().map(|centre| outer(centre - middle)).fold(DMat3::ZERO, sum);
        let spread = flight.x_axis.x + flight.y_axis.y + flight.z_axis.z;
        let flight = if spread > 0.0 { flight * (FLATNESS / spread) } else { DMat3::ZERO };
        let level = rows * (1.0 / count);
        let (values, axes) = eigen(level + flight);
        let least = (0..3).min_by(|&a, &b| values[a].total_cmp(&values[b]))?;
        let up = axes.col(least);
        let above = |frame: &Frame| (frame.pose.rotation.inverse() * (-DVec3::Y - DVec3::Z)).dot(up);
        let side = frames.iter().map(above).sum::<f64>() / count;
        let up = if side < 0.0 { -up } else { up };
        let next = (0..3).filter(|&other| other != least).map(|other| values[other]).fold(f64::INFINITY, f64::min);
        let leans = up.dot(level * up).max(0.0).sqrt().min(1.0).asin().to_degrees();
        let sure = next > 4.0 * values[least].max(1e-4) && side.abs() > 0.2;
        let up = (up * STEPS).round() / STEPS;
        up.is_finite().then(|| Upright { up: up.to_array(), leans, sure })
    }
}

/// Eigenvalues and eigenvectors, one a column, of a symmetric matrix (Jacobi's rotations: Golub and Van Loan, Matrix Computations,
/// section 8.5).
fn eigen(mut matrix: DMat3) -> ([f64; 3], DMat3) {
    let mut axes = DMat3::IDENTITY;
    for _ in 0..16 {
        for (p, q) in [(0, 1), (0, 2), (1, 2)] {
            let apart = matrix.col(q)[p];
            if apart.abs() <= f64::MIN_POSITIVE {
                continue;
            }
            let tau = (matrix.col(q)[q] - matrix.col(p)[p]) / (2.0 * apart);
            let tangent = tau.signum() / (tau.abs() + tau.hypot(1.0));
            let cosine = tangent.hypot(1.0).recip();
            let sine = tangent * cosine;
            let mut turn = DMat3::IDENTITY;
            (turn.col_mut(p)[p], turn.col_mut(q)[q]) = (cosine, cosine);
            (turn.col_mut(q)[p], turn.col_mut(p)[q]) = (sine, -sine);
            matrix = turn.transpose() * matrix * turn;
            axes *= turn;
        }
    }
    ([matrix.x_axis.x, matrix.y_axis.y, matrix.z_axis.z], axes)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DQuat, DVec2};

    use super::*;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;

    /// Cameras at these places, each looking along a direction with its rows level about `up`, and rolled by an angle.
    fn frames(up: DVec3, cameras: &[(DVec3, DVec3, f64)]) -> Vec<Frame> {
        let lens = Lens::pinhole(DVec2::splat(50.0), DVec2::splat(20.0));
        let camera = Arc::new(Camera { width: 40, height: 40, lens });
        let frame = |&(centre, forward, roll): &(DVec3, DVec3, f64)| {
            let forward = forward.normalize();
            let right = forward.cross(up).try_normalize().unwrap_or(up.any_orthonormal_vector());
            let axes = DMat3::from_cols(right, forward.cross(right), forward);
            let rotation = DQuat::from_rotation_z(roll) * DQuat::from_mat3(&axes).inverse();
            Frame {
                name: "a".into(),
                camera: camera.clone(),
                pose: Pose { rotation, translation: -(rotation * centre) },
            }
        };
        cameras.iter().map(frame).collect()
    }

    fn angle(found: Upright, up: DVec3) -> f64 {
        DVec3::from(found.up).angle_between(up).to_degrees()
    }

    #[test]
    fn level_cameras_tell_the_way_up() {
        for up in [DVec3::Z, -DVec3::Y, DVec3::new(0.1, -0.3, -0.9).normalize()] {
            let (x, y) = up.any_orthonormal_pair();
            let around = |n: i32| x * f64::from(n).cos() + y * f64::from(n).sin();
            let roll = |n: i32| 0.05 * f64::from(n * 7 % 5 - 2);
            let walk: Vec<_> =
                (0..20).map(|n| (x * f64::from(n) + up * 0.1 * roll(n), around(n * n), roll(n))).collect();
            let orbit: Vec<_> =
                (0..20).map(|n| (around(n) * 9.0 + up * 5.0, -around(n) * 9.0 - up * 5.0, roll(n))).collect();
            // Strips in one direction and back, cameras straight down.
            let nadir: Vec<_> = (0..20)
                .map(|n| {
                    let strip = y * f64::from(n / 5) * 3.0;
                    let forward = if n / 5 % 2 == 0 { x } else { -x };
                    (strip + x * f64::from(n % 5) + up * 30.0, -up + forward * 1e-3, roll(n))
                })
                .collect();
            for cameras in [walk, orbit, nadir] {
                let found = Upright::of(&frames(up, &cameras)).unwrap();
                assert!(angle(found, up) < 2.0 && found.sure, "{up}: {found:?}");
                assert!(found.leans < 6.0, "{found:?}");
            }
        }
    }

    #[test]
    fn one_camera_is_not_sure_and_none_tells_nothing() {
        assert_eq!(Upright::of(&[]), None);
        let one = Upright::of(&frames(DVec3::Z, &[(DVec3::ZERO, DVec3::new(1.0, 0.0, -1.0), 0.0)])).unwrap();
        assert!(!one.sure);
    }
}
