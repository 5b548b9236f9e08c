//! What share of a scene its cameras see: where they see none of it, cameras and scene are in different coordinates.

use glam::DVec3;

use super::frame::Frame;

/// The most frames and points that are tried.
const FRAMES: usize = 64;
const POINTS: usize = 512;

/// The share of points that are in the image of a frame at least, whether something hides them or not; 0 where there are none.
pub(crate) fn share_seen(frames: &[Frame], points: &[DVec3]) -> f64 {
    let frames: Vec<&Frame> = frames.iter().step_by(frames.len().div_ceil(FRAMES).max(1)).collect();
    let points: Vec<DVec3> = points.iter().copied().step_by(points.len().div_ceil(POINTS).max(1)).collect();
    let seen = points.iter().filter(|&&point| frames.iter().any(|frame| sees(frame, point))).count();
    if seen == 0 { 0.0 } else { seen as f64 / points.len() as f64 }
}

/// The middle of some points, in words.
pub(crate) fn middle(points: &[DVec3]) -> String {
    let middle = points.iter().sum::<DVec3>() / points.len().max(1) as f64;
    middle.to_array().map(|v| format!("{v:.1}")).join(" ")
}

/// Whether a point lies in the image of a frame.
fn sees(Frame { camera, pose, .. }: &Frame, point: DVec3) -> bool {
    let inside = |at: f64, side: u32| (0.0..f64::from(side)).contains(&at);
    let pixel = camera.project(pose.to_camera(point));
    pixel.is_some_and(|at| inside(at.x, camera.width) && inside(at.y, camera.height))
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec2;

    use super::*;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;

    #[test]
    fn a_point_behind_all_cameras_or_beside_all_images_is_not_seen() {
        let lens = Lens::pinhole(DVec2::splat(50.0), DVec2::splat(20.0));
        let camera = Arc::new(Camera { width: 40, height: 40, lens });
        let frame = |x: f64| Frame {
            name: String::new(),
            camera: Arc::clone(&camera),
            pose: Pose::look_at(DVec3::new(x, 0.0, 10.0), DVec3::X * x, DVec3::Y),
        };
        let frames: Vec<Frame> = (0..200).map(|at| frame(f64::from(at) * 0.1)).collect();
        let points = [DVec3::ZERO, DVec3::X * 15.0, DVec3::Z * 12.0, DVec3::X * 90.0];
        assert_eq!(share_seen(&frames, &points).to_bits(), 0.5f64.to_bits());
        assert_eq!((share_seen(&frames, &[]).to_bits(), share_seen(&[], &points).to_bits()), (0, 0));
    }
}
