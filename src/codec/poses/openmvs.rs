//! OpenMVS' `.mvs` (`libs/MVS/Interface.h` of OpenMVS), little endian:
//!
//! ```text
//! "MVSI", u32 version, u32 reserved         nothing of it in version 0
//! platforms   u64 count; each name, cameras, poses
//!   camera    name, [3: band name], [1: u32 width, height], K, R, C       f64 by rows; R and C within the platform
//!   pose      R, C                                                       R world-to-camera, C the centre
//! images      u64 count; each name, [5: mask name], u32 platform, camera, pose, [3: u32 id],
//!             [7: f32 depths (3), u64 count of 24 bytes each]
//! ```
//!
//! A name is its u64 length and its bytes; [n] stands for what is there since version n, or after it. Axes are ours, and the
//! centre of the first pixel is at 0. Images have no distortion. A camera whose size is 0 is in units of the larger side.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::bytes::Bytes;
use super::format::{PoseFormat, Posed, Target};
use super::photographs::Photographs;
use super::{found, names, posed, terms, whole};
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::images::Size;
use crate::scene::camera::{Camera, Lens, Projection};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// OpenMVS' scene.
pub(crate) const OPENMVS: PoseFormat = PoseFormat {
    name: "openmvs",
    programs: "OpenMVS",
    target: Target::Either,
    advice: "name scene.mvs or the folder that holds it",
    is_at: |path| file(path).is_some_and(|file| whole::start(&file, 4) == b"MVSI"),
    missing: |path| found::missing(path, file(path).is_some(), "must be a .mvs file or hold scene.mvs"),
    read,
};

/// The newest version that is known.
const NEWEST: u32 = 7;

/// The number of a pose that is none.
const NONE: u32 = u32::MAX;

/// The bytes of a score of an image.
const SCORE: u64 = 24;

fn file(path: &Path) -> Option<PathBuf> {
    found::named(path, &["scene.mvs"]).or_else(|| found::ending(path, &[".mvs"]).into_iter().next())
}

/// A camera of a platform.
struct CameraOf {
    size: [u32; 2],
    matrix: [f64; 9],
    placed: Placed,
}

/// A rotation and a centre.
struct Placed {
    rotation: DMat3,
    centre: DVec3,
}

#[derive(Default)]
struct Platform {
    cameras: Vec<CameraOf>,
    poses: Vec<Placed>,
}

struct Image {
    name: String,
    platform: u32,
    camera: u32,
    pose: u32,
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no .mvs file is there"))?;
    let version = version(&file)?;
    let mut bytes = Bytes::open(&file)?;
    let parsed = scene(&mut bytes, version);
    let (platforms, images) = bytes.finish(&file, parsed)?;
    let written: Vec<String> = images.iter().map(|image| image.name.clone()).collect();
    let (mut frames, mut unposed) = (Vec::<Frame>::new(), Vec::new());
    for (image, name) in images.iter().zip(names::settled(&written, photographs)?) {
        let fault = |why| Error::malformed(&file, format!("image {}: {why}", shown(&image.name)));
        if image.pose == NONE {
            unposed.push(name);
            continue;
        }
        let (camera, pose) = image.placed(&platforms).map_err(fault)?;
        let size = match camera.size {
            [0, _] | [_, 0] => photographs.size(&name)?,
            [width, height] => Size { width, height },
        };
        let camera = camera.camera(size).map_err(fault)?;
        let same = frames.last().map(|last| &last.camera).filter(|last| ***last == camera);
        let camera = same.map_or_else(|| Arc::new(camera.clone()), Arc::clone);
        frames.push(Frame { name, camera, pose });
    }
    Ok(Posed { frames, unposed, ..Posed::default() })
}

/// The version of a file; 0 where it has no head.
fn version(file: &Path) -> Result<u32> {
    let start = whole::start(file, 12);
    if start.starts_with(b"MVS\0") {
        let found = "it is a project of OpenMVS' own applications (MVS): export it with --export-type, or name the .mvs \
                     that the importer wrote";
        return Err(Error::malformed(file, found));
    }
    match (start.strip_prefix(b"MVSI"), start.get(4..8)) {
        (Some(_), Some(version)) => {
            let version = version.iter().rev().fold(0, |all, byte| all << 8 | u32::from(*byte));
            if version <= NEWEST {
                return Ok(version);
            }
            Err(Error::malformed(file, format!("it is of version {version}; 0 to {NEWEST} are read")))
        }
        (Some(_), None) => Err(Error::malformed(file, "the file ends within its head")),
        (None, _) => Ok(0),
    }
}

/// The platforms and the images of a file. What follows them is passed over.
fn scene(bytes: &mut Bytes, version: u32) -> Result<(Vec<Platform>, Vec<Image>), String> {
    if version > 0 {
        bytes.skip(Some(12))?;
    }
    let platforms = each(bytes, "platform", |bytes| platform(bytes, version))?;
    let images = each(bytes, "image", |bytes| image(bytes, version))?;
    Ok((platforms, images))
}

/// As many elements as the next number says.
fn each<T>(
    bytes: &mut Bytes,
    what: &str,
    mut one: impl FnMut(&mut Bytes) -> Result<T, String>,
) -> Result<Vec<T>, String> {
    let count = bytes.u64().map_err(|why| format!("the number of its {what}s: {why}"))?;
    let mut all = Vec::new();
    for at in 0..count {
        all.push(one(bytes).map_err(|why| format!("{what} {} of {count}: {why}", at + 1))?);
    }
    Ok(all)
}

fn platform(bytes: &mut Bytes, version: u32) -> Result<Platform, String> {
    bytes.counted_name()?;
    let cameras = each(bytes, "camera", |bytes| {
        bytes.counted_name()?;
        if version > 3 {
            bytes.counted_name()?;
        }
        let size = if version > 0 { [bytes.u32()?, bytes.u32()?] } else { [0, 0] };
        Ok(CameraOf { size, matrix: bytes.f64s()?, placed: placed(bytes)? })
    })?;
    Ok(Platform { cameras, poses: each(bytes, "pose", placed)? })
}

fn placed(bytes: &mut Bytes) -> Result<Placed, String> {
    Ok(Placed { rotation: posed::rows(bytes.f64s()?), centre: bytes.f64s()?.into() })
}

fn image(bytes: &mut Bytes, version: u32) -> Result<Image, String> {
    let name = bytes.counted_name()?;
    if version > 4 {
        bytes.counted_name()?;
    }
    let image = Image { name, platform: bytes.u32()?, camera: bytes.u32()?, pose: bytes.u32()? };
    if version > 2 {
        bytes.u32()?;
    }
    if version > 6 {
        bytes.skip(Some(12))?;
        let scores = bytes.u64()?;
        bytes.skip(scores.checked_mul(SCORE))?;
    }
    Ok(image)
}

impl Image {
    /// The camera and the pose of the image.
    fn placed<'a>(&self, platforms: &'a [Platform]) -> Result<(&'a CameraOf, Pose), String> {
        let platform = platforms.get(self.platform as usize);
        let platform = platform.ok_or_else(|| format!("its platform {} is not there", self.platform))?;
        let camera = platform.cameras.get(self.camera as usize);
        let camera = camera.ok_or_else(|| format!("its camera {} is not there", self.camera))?;
        let pose = platform.poses.get(self.pose as usize);
        let pose = pose.ok_or_else(|| format!("its pose {} is not there", self.pose))?;
        let centre = pose.rotation.transpose() * camera.placed.centre + pose.centre;
        Ok((camera, posed::at_centre(camera.placed.rotation * pose.rotation, centre)?))
    }
}

impl CameraOf {
    fn camera(&self, Size { width, height }: Size) -> Result<Camera, String> {
        let [fx, skew, cx, _, fy, cy, ..] = self.matrix;
        let unit = if self.size.contains(&0) { f64::from(width.max(height)) } else { 1.0 };
        terms::negligible("skew", skew, skew * unit * 0.5 * f64::from(height) / (fy * unit))?;
        let centre = DVec2::new(cx, cy) * unit + DVec2::splat(0.5);
        let lens = Lens::new(DVec2::new(fx, fy) * unit, centre, Projection::Pinhole)?;
        Camera::new(width.into(), height.into(), lens)
    }
}
