//! The way up, as a scene tells it: people hold a camera level and fly at one height, and wide ground is flat.

use std::fmt;

use glam::{DMat3, DVec3};

use super::frame::Frame;
use super::georeference::Georeference;

/// The way up that a scene tells.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Upright {
    /// The way up in the coordinates of the poses, of a length of about 1: each component is rounded, to a multiple of 1/128 where
    /// cameras or ground tell it, so that a frame more seldom moves it.
    pub up: [f64; 3],
    /// What tells it.
    pub by: By,
}

/// What tells the way up.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum By {
    /// The coordinate reference system.
    System,
    /// The cameras' rows of pixels, which are horizontal but for so many degrees, root mean square.
    Rows(f64),
    /// The ground under cameras that look down.
    Ground,
    /// The cameras' rows of pixels, though they lean by so many degrees, or another direction would do nearly as well.
    Unsure(f64),
}

impl fmt::Display for Upright {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.up;
        write!(f, "up is [{x:.3}, {y:.3}, {z:.3}]")?;
        match self.by {
            By::System => f.write_str(", by the coordinate reference system"),
            By::Rows(lean) => write!(f, ", by cameras that are level but for {lean:.1} degrees"),
            By::Ground => f.write_str(", by the plane of the ground"),
            By::Unsure(lean) => {
                write!(f, ", by cameras that lean by {lean:.1} degrees: this is unsure, give [scene] up")
            }
        }
    }
}

/// How much the flatness of the flight counts beside how level the cameras are: it decides where all rows of pixels are parallel.
const FLATNESS: f64 = 0.05;

/// Cameras that lean by more, in degrees, are not held level.
const LEVEL: f64 = 3.0;

/// Ground is flat where its height varies by less than this part of its width, in variances.
const FLAT: f64 = 0.1;

/// Steps of each component.
const STEPS: f64 = 128.0;

impl Upright {
    /// The way up that the system of the coordinates tells where these cameras stand. `None` where it tells none.
    pub fn in_system(place: Option<Georeference>, frames: &[Frame]) -> Option<Upright> {
        let up = place?.up(middle(frames)).filter(|up| up.is_finite())?;
        Some(Upright { up: up.to_array(), by: By::System })
    }

    /// The way up that cameras tell if they are level, or else the ground, of which `ground` gives some points, if it is flat and
    /// they look down on it. `None` without cameras.
    pub fn of(frames: &[Frame], ground: impl FnOnce() -> Option<Vec<DVec3>>) -> Option<Upright> {
        let (up, leans, sure) = by_rows(frames)?;
        let (up, by) = match sure && leans < LEVEL {
            true => (up, By::Rows(leans)),
            false => match ground().and_then(|points| by_ground(frames, points)) {
                Some(up) => (up, By::Ground),
                None => (up, By::Unsure(leans)),
            },
        };
        // Nothing is -0.
        let up = (up * STEPS).round() / STEPS + DVec3::ZERO;
        up.is_finite().then(|| Upright { up: up.to_array(), by })
    }
}

fn outer(v: DVec3) -> DMat3 {
    DMat3::from_cols(v * v.x, v * v.y, v * v.z)
}

fn sum(all: DMat3, one: DMat3) -> DMat3 {
    all + one
}

/// The centre of the cameras.
pub(crate) fn middle(frames: &[Frame]) -> DVec3 {
    frames.iter().map(|frame| frame.pose.centre()).sum::<DVec3>() / frames.len() as f64
}

/// The direction that is the most nearly perpendicular to all rows of pixels and to the flight, on the side that the tops of the
/// photographs and the backs of the cameras are on; how far the rows lean, degrees; whether no other direction would do nearly as
/// well.
fn by_rows(frames: &[Frame]) -> Option<(DVec3, f64, bool)> {
    let (count, middle) = (frames.len() as f64, middle(frames));
    let rows = frames.iter().map(|frame| outer(frame.pose.to_world(DVec3::X))).fold(DMat3::ZERO, sum);
    let flight = frames.iter().map(|frame| outer(frame.pose.centre() - middle)).fold(DMat3::ZERO, sum);
    let spread = flight.x_axis.x + flight.y_axis.y + flight.z_axis.z;
    let flight = if spread > 0.0 { flight * (FLATNESS / spread) } else { DMat3::ZERO };
    let level = rows * count.recip();
    let [(least, up), (next, _), _] = eigen(level + flight)?;
    let above = |frame: &Frame| frame.pose.to_world(-DVec3::Y - DVec3::Z).dot(up);
    let side = frames.iter().map(above).sum::<f64>() / count;
    let leans = up.dot(level * up).max(0.0).sqrt().min(1.0).asin().to_degrees();
    Some((if side < 0.0 { -up } else { up }, leans, next > 4.0 * least.max(1e-4) && side.abs() > 0.2))
}

/// The normal of the plane of most of the points, towards the cameras; `None` where they are no plane, or where the cameras do not
/// look down on it.
fn by_ground(frames: &[Frame], mut points: Vec<DVec3>) -> Option<DVec3> {
    let median = |axis: usize| {
        let mut values: Vec<f64> = points.iter().map(|at| at[axis]).collect();
        values.sort_by(f64::total_cmp);
        values.get(values.len() / 2).copied()
    };
    let median = DVec3::new(median(0)?, median(1)?, median(2)?);
    points.sort_by(|a, b| a.distance_squared(median).total_cmp(&b.distance_squared(median)));
    points.truncate((points.len() * 4).div_ceil(5));
    let spread = points.iter().map(|&at| outer(at - median)).fold(DMat3::ZERO, sum) * (points.len() as f64).recip();
    let [(height, normal), (width, _), _] = eigen(spread)?;
    let up = if normal.dot(middle(frames) - median) < 0.0 { -normal } else { normal };
    let down = frames.iter().map(|frame| -frame.pose.to_world(DVec3::Z).dot(up)).sum::<f64>() / frames.len() as f64;
    (height < FLAT * width && down > 0.5).then_some(up)
}

/// Eigenvalues, ascending, and eigenvectors of a symmetric matrix (Jacobi's rotations: Golub and Van Loan, Matrix Computations,
/// section 8.5); `None` for one that is not finite.
fn eigen(mut matrix: DMat3) -> Option<[(f64, DVec3); 3]> {
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
    let mut all = [0, 1, 2].map(|at| (matrix.col(at)[at], axes.col(at)));
    all.sort_by(|a, b| a.0.total_cmp(&b.0));
    (matrix.is_finite() && axes.is_finite()).then_some(all)
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
            let roll = |n: i32| 0.02 * f64::from(n * 7 % 5 - 2);
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
                let found = Upright::of(&frames(up, &cameras), || None).unwrap();
                assert!(angle(found, up) < 2.0 && matches!(found.by, By::Rows(_)), "{up}: {found:?}");
            }
        }
    }

    #[test]
    fn the_ground_tells_where_cameras_lean() {
        let up = DVec3::new(0.1, -0.3, -0.9).normalize();
        let (x, y) = up.any_orthonormal_pair();
        let at = |n: i32| x * f64::from(n % 7) + y * f64::from(n / 7);
        let lean = |n: i32| x * 0.4 * f64::from(n * 5 % 3 - 1) + y * 0.4 * f64::from(n * 7 % 5 - 2);
        let cameras: Vec<_> = (0..28).map(|n| (at(n) + up * 9.0, lean(n) - up, f64::from(n * 11 % 7))).collect();
        let frames = frames(up, &cameras);
        let ground: Vec<DVec3> =
            (0..400).map(|n| x * f64::from(n % 20) + y * f64::from(n / 20) + up * 0.3 * f64::from(n % 3)).collect();
        let far = [x * 1e5, -up * 1e5];
        let found = Upright::of(&frames, || Some([&ground[..], &far].concat())).unwrap();
        assert!(angle(found, up) < 1.0 && found.by == By::Ground, "{found:?}");
        // Neither a wall that they do not look at, nor what is no plane.
        let wall = (0..400).map(|n| x * f64::from(n % 20) + up * f64::from(n / 20)).collect();
        let ball = (0..400).map(|n| x * f64::from(n % 7) + y * f64::from(n * 3 % 11) + up * f64::from(n % 9)).collect();
        for points in [wall, ball, Vec::new()] {
            assert!(matches!(Upright::of(&frames, || Some(points)).unwrap().by, By::Unsure(_)));
        }
    }

    #[test]
    fn one_camera_is_not_sure_and_none_tells_nothing() {
        assert_eq!(Upright::of(&[], || None), None);
        let earth = Georeference { crs: "EPSG:4978".parse().ok(), offset: [0.0; 3] };
        assert_eq!(Upright::in_system(Some(earth), &[]), None);
        let one = Upright::of(&frames(DVec3::Z, &[(DVec3::ZERO, DVec3::new(1.0, 0.0, -1.0), 0.0)]), || None).unwrap();
        assert!(matches!(one.by, By::Unsure(_)));
    }
}
