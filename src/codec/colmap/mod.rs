//! COLMAP's sparse models: cameras and images, binary or text (COLMAP documentation, "Output Format").
//!
//! - Poses are world-to-camera: a quaternion (w, x, y, z) and a translation, which is not the camera's centre.
//! - Where both are there, the binary files count. `rigs` and `frames`, which COLMAP writes since version 3.12, repeat
//!   what `images` says and are not read; nor are points.
//! - Ids need not be contiguous. Names are relative to the image folder; one that could leave it is refused.
//! - What is wrong is told with the file and the camera's or image's number.

mod binary;
#[cfg(test)]
mod tests;
mod text;
mod write;

pub use write::{Encoding, write_model};

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use crate::base::{Error, Result};
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// Cameras by their id.
type Cameras = BTreeMap<u32, Arc<Camera>>;

/// Reads a model's folder: its frames, sorted by name.
///
/// # Errors
/// No model there; a file that is cut short or holds what cannot be; a camera model that gonio does not know.
pub fn read_model(folder: &Path) -> Result<Vec<Frame>> {
    let file = |name: &str| Some(folder.join(name)).filter(|path| path.is_file());
    let mut frames = match (file("cameras.bin"), file("images.bin"), file("cameras.txt"), file("images.txt")) {
        (Some(cameras), Some(images), ..) => binary::images(&images, &binary::cameras(&cameras)?)?,
        (_, _, Some(cameras), Some(images)) => text::images(&images, &text::cameras(&cameras)?)?,
        _ => {
            let found = "no COLMAP model: cameras.bin and images.bin, or cameras.txt and images.txt, are needed";
            return Err(Error::malformed(folder, found));
        }
    };
    frames.sort_by(|a, b| a.name.cmp(&b.name));
    match frames.windows(2).find(|w| w[0].name == w[1].name) {
        Some(twins) => Err(Error::malformed(folder, format!("two images are named {:?}", twins[0].name))),
        None => Ok(frames),
    }
}

/// A frame out of what a file says of it, or what is wrong with that.
fn frame(name: &str, quaternion: [f64; 4], translation: [f64; 3], camera: u32, all: &Cameras) -> Result<Frame, String> {
    let bad_part = |part: &str| part.is_empty() || part == "." || part == "..";
    if name.contains(['\\', '\0']) || name.split('/').any(bad_part) {
        return Err(format!("its name {name:?} is none: a path below the image folder is needed"));
    }
    let [w, x, y, z] = quaternion;
    let rotation = DQuat::from_xyzw(x, y, z, w);
    let length = rotation.length();
    if !(length.is_finite() && length > 1e-6) {
        return Err(format!("its rotation is the quaternion {quaternion:?}, which turns nothing"));
    }
    let translation = DVec3::from(translation);
    if !translation.is_finite() {
        return Err(format!("its translation is {translation}: every component must be finite"));
    }
    let camera = all.get(&camera).ok_or_else(|| format!("it is of camera {camera}, which is not among the cameras"))?;
    let pose = Pose { rotation: rotation.normalize(), translation };
    Ok(Frame { name: name.to_owned(), camera: Arc::clone(camera), pose })
}

/// Puts a camera among the others, or says what is wrong with it.
fn add_camera(all: &mut Cameras, id: u32, camera: Result<Camera, String>) -> Result<(), String> {
    match all.insert(id, Arc::new(camera?)) {
        Some(_) => Err("another camera has this id".to_owned()),
        None => Ok(()),
    }
}
