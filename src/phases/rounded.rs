//! Photographs that are smaller than their cameras, where the sides do not divide: programs round a side up or down. Where one was
//! rounded up, the camera becomes that of an image whose sides do divide, so that each side keeps its true scale.

use std::path::Path;
use std::sync::Arc;

use crate::codec::images::{self, Size};
use crate::scene::frame::Frame;

/// Resizes the cameras of frames whose photographs are `downscale` times smaller and rounded up along a side. A photograph that
/// cannot be read is told of when it is skipped.
pub(super) fn round_up(frames: &mut [Frame], images: &Path, downscale: u32) {
    for frame in frames {
        let camera = Size { width: frame.camera.width, height: frame.camera.height };
        if [camera.width, camera.height].iter().all(|side| side.is_multiple_of(downscale.max(1))) {
            continue;
        }
        let Ok(size) = images::size(&images.join(&frame.name)) else { continue };
        let down = Size { width: camera.width / downscale, height: camera.height / downscale };
        if size != down && size.is_smaller(camera, downscale) {
            frame.camera = Arc::new(frame.camera.resized(size.width * downscale, size.height * downscale));
        }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;

    #[test]
    fn a_side_that_is_rounded_up_keeps_its_scale() {
        let dir = tempfile::tempdir().unwrap();
        let camera =
            Camera { width: 159, height: 119, lens: Lens::pinhole(DVec2::splat(144.0), DVec2::new(79.5, 59.5)) };
        let camera = Arc::new(camera);
        for (size, small, kept) in [
            ([80, 60], [80, 60], false),
            ([79, 60], [79, 60], false),
            ([79, 59], [79, 59], true),
            ([81, 60], [79, 59], true),
            ([159, 119], [79, 59], true),
        ] {
            image::RgbImage::new(size[0], size[1]).save(dir.path().join("a.png")).unwrap();
            let pose = Pose::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y);
            let mut frames = [Frame { name: "a.png".to_owned(), camera: Arc::clone(&camera), pose }];
            round_up(&mut frames, dir.path(), 2);
            let found = frames[0].camera.down_scaled(2);
            assert_eq!(
                ([found.width, found.height], Arc::ptr_eq(&frames[0].camera, &camera)),
                (small, kept),
                "{size:?}"
            );
            // The middle stays the middle, and the edge the edge.
            let scale = DVec2::new(f64::from(small[0]) / 159.0, f64::from(small[1]) / 119.0);
            for at in [DVec2::new(79.5, 59.5), DVec2::new(159.0, 119.0), DVec2::new(3.0, 7.0)] {
                let (full, half) = (camera.ray(at).unwrap(), found.ray(at * scale).unwrap());
                assert!(full.distance(half) < 1e-12, "{size:?} {at}");
            }
        }
        let mut gone = [Frame {
            name: "b.png".to_owned(),
            camera: Arc::clone(&camera),
            pose: Pose::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y),
        }];
        round_up(&mut gone, dir.path(), 2);
        assert!(Arc::ptr_eq(&gone[0].camera, &camera));
    }
}
