//! Cameras of BlendedMVS and of MVSNet: a folder `cams` with `00000000_cam.txt` for each image (MVSNet's README, "Input").
//!
//! ```text
//! extrinsic       4x4 by rows, world-to-camera
//! intrinsic       3x3 by rows, pixels
//! depths          2 or 4 numbers, not read
//! ```
//!
//! Axes are ours, and the centre of the first pixel is at 0.5. There is no distortion. Sizes are those of the images.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DMat4, DVec2};

use super::format::{PoseFormat, Posed, Target};
use super::photographs::Photographs;
use super::words::Words;
use super::{found, names, posed, terms, whole};
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::images::Size;
use crate::scene::camera::{Camera, Lens, Projection};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// BlendedMVS' cameras.
pub(crate) const BLENDEDMVS: PoseFormat = PoseFormat {
    name: "blendedmvs",
    programs: "BlendedMVS, MVSNet",
    target: Target::Folder,
    advice: "name the folder cams that holds *_cam.txt",
    is_at: |path| !cameras(path).is_empty(),
    missing: |path| found::missing(path, !cameras(path).is_empty(), "must hold *_cam.txt"),
    read,
};

/// The end of a camera's name.
const END: &str = "_cam.txt";

fn cameras(folder: &Path) -> Vec<PathBuf> {
    if !folder.is_dir() {
        return Vec::new();
    }
    let here = found::ending(folder, &[END]);
    if here.is_empty() { found::ending(&folder.join("cams"), &[END]) } else { here }
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let files = cameras(path);
    let stem = |file: &PathBuf| file.file_name().unwrap_or_default().to_string_lossy().trim_end_matches(END).to_owned();
    let written: Vec<String> = files.iter().map(stem).collect();
    let mut frames = Vec::with_capacity(files.len());
    for ((file, written), name) in files.iter().zip(&written).zip(names::settled(&written, photographs)?) {
        let text = whole::text(file)?;
        let fault = |why| Error::malformed(file, why);
        let (pose, lens) = one(&text).map_err(fault)?;
        let Size { width, height } =
            photographs.size(&name).map_err(|why| why.doing(format!("camera {}", shown(written))))?;
        let camera = Arc::new(Camera::new(width.into(), height.into(), lens).map_err(fault)?);
        frames.push(Frame { name, camera, pose });
    }
    Ok(frames.into())
}

fn one(text: &str) -> Result<(Pose, Lens), String> {
    let mut words = Words::of(text);
    let heading = |words: &mut Words<'_>, wanted: &str| match words.word() {
        Some(word) if word == wanted => Ok(()),
        other => {
            Err(format!("line {}: {wanted} is needed, not {}", words.line_number(), shown(other.unwrap_or_default())))
        }
    };
    heading(&mut words, "extrinsic")?;
    let extrinsic = words.numbers::<16>("the extrinsic")?;
    if extrinsic[12..] != [0.0, 0.0, 0.0, 1.0] {
        return Err(format!("the last row of the extrinsic is {:?}; it must be 0 0 0 1", &extrinsic[12..]));
    }
    let matrix = DMat4::from_cols_array(&extrinsic).transpose();
    heading(&mut words, "intrinsic")?;
    let [fx, skew, cx, _, fy, cy, ..] = words.numbers::<9>("the intrinsic")?;
    terms::negligible("skew", skew, skew * cy / fy)?;
    let lens = Lens::new(DVec2::new(fx, fy), DVec2::new(cx, cy), Projection::Pinhole)?;
    Ok((posed::moved(DMat3::from_mat4(matrix), matrix.w_axis.truncate())?, lens))
}
