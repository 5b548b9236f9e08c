//! Every format against the same cameras (`same_rays`), as other programs and systems write it (`as_written`), what it says of their place (`places`), against damage (`damaged`), against what it must refuse (`refused`),
//! and against files of the programs themselves, where they are there (`real`); the seeds of the fuzz target (`seeds`).

mod as_written;
mod damaged;
mod places;
mod real;
mod refused;
mod same_rays;
mod seeds;
pub(crate) mod writers;

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DVec2, DVec3};

use super::Listed;
use super::{Photographs, PoseFormat, Posed, look};
use crate::base::Result;
use crate::codec::images::Size;
use crate::scene::camera::{Camera, Distortion, Lens, Projection};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// The size of the test's images.
const SIZE: Size = Size { width: 640, height: 480 };

impl Listed {
    fn of(frames: &[Frame]) -> Self {
        Listed { names: frames.iter().map(|frame| frame.name.clone()).collect(), size: SIZE }
    }
}

/// What the lenses of a format can say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Says {
    /// A principal point and nothing else.
    Pinhole,
    /// Two radial terms about the image's centre.
    Radial,
    /// Radial terms about a principal point.
    RadialOff,
    /// One radial term that says the way back, about the image's centre.
    Inward,
    /// Three radial terms, two tangential ones, and a principal point.
    Brown,
    /// The same with two radial terms.
    Brown4,
}

/// The lens of the scene, as far as a format can say it.
fn lens(says: Says) -> Lens {
    let (middle, off) = (DVec2::new(320.0, 240.0), DVec2::new(331.25, 228.5));
    let flat = Projection::Perspective;
    let (centre, projection) = match says {
        Says::Pinhole => (off, Projection::Pinhole),
        Says::Radial => (middle, flat(Distortion::radial([-0.11, 0.032]))),
        Says::RadialOff => (off, flat(Distortion::radial([-0.11, 0.032, -0.006]))),
        Says::Inward => (middle, Projection::Inward(Distortion::radial([0.14]))),
        Says::Brown4 => {
            let radial = Distortion::radial([-0.11, 0.032]);
            (off, flat(Distortion { tangential: [1.3e-3, -2.1e-3], ..radial }))
        }
        Says::Brown => {
            let radial = Distortion::radial([-0.11, 0.032, -0.006]);
            (off, flat(Distortion { tangential: [1.3e-3, -2.1e-3], ..radial }))
        }
    };
    Lens::new(DVec2::splat(512.5), centre, projection).unwrap()
}

/// One scene: a look straight down, oblique ones, and one that is turned on its side.
pub(crate) fn scene(says: Says) -> Vec<Frame> {
    let camera = Arc::new(Camera::new(SIZE.width.into(), SIZE.height.into(), lens(says)).unwrap());
    let looks = [
        (DVec3::new(1.0, -2.0, 40.0), DVec3::new(1.5, -1.0, 0.0), DVec3::Y),
        (DVec3::new(-30.0, 5.0, 22.0), DVec3::new(2.0, 3.0, 1.0), DVec3::Z),
        (DVec3::new(20.0, 31.0, 18.0), DVec3::new(-4.0, 2.0, 3.0), DVec3::new(0.3, -0.2, 1.0)),
        (DVec3::new(3.0, -35.0, 12.0), DVec3::new(0.0, 0.0, 4.0), DVec3::X),
    ];
    let frame = |(at, (eye, target, up)): (usize, (DVec3, DVec3, DVec3))| Frame {
        name: format!("{:08}.jpg", at + 3),
        camera: Arc::clone(&camera),
        pose: Pose::look_at(eye, target, up),
    };
    looks.into_iter().enumerate().map(frame).collect()
}

/// How far, in pixels, what one frame sees is from where the other sees it, at worst over the image.
pub(crate) fn apart(a: &Frame, b: &Frame) -> f64 {
    let mut worst = 0.0f64;
    let along = |side: u32| (0..=8).map(move |step| f64::from(side) * f64::from(step) / 8.0);
    for pixel in along(a.camera.height).flat_map(|y| along(a.camera.width).map(move |x| DVec2::new(x, y))) {
        let ray = a.camera.ray(pixel).unwrap();
        for distance in [5.0, 60.0] {
            let point = a.pose.centre() + a.pose.to_world(ray) * distance;
            let seen = b.camera.project(b.pose.to_camera(point));
            worst = worst.max(seen.map_or(f64::INFINITY, |seen| seen.distance(pixel)));
        }
    }
    worst
}

/// Writes files into a folder.
pub(crate) fn write(folder: &Path, files: &BTreeMap<String, Vec<u8>>) {
    for (name, bytes) in files {
        let path = folder.join(name);
        std::fs::create_dir_all(path.parent().unwrap()).unwrap();
        std::fs::write(path, bytes).unwrap();
    }
}

/// What a format reads of files.
fn read(format: &PoseFormat, files: &BTreeMap<String, Vec<u8>>, photographs: &dyn Photographs) -> Result<Posed> {
    let folder = tempfile::tempdir().unwrap();
    write(folder.path(), files);
    look(format, folder.path(), photographs)
}
