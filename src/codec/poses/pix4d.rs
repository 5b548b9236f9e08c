//! Pix4D's `*_calibrated_camera_parameters.txt` (Pix4D's support article of that name): eight lines that say what follows, then
//! ten lines an image.
//!
//! ```text
//! name width height
//! K (three rows)
//! radial k1 k2 k3
//! tangential t1 t2                     in OpenCV's order
//! camera's centre
//! R (three rows)                       world-to-camera
//! ```
//!
//! Axes are ours, and the principal point is in pixels whose first has its centre at 0.5. Coordinates, like those of Pix4D's
//! meshes, are relative to `*_offset.xyz`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::format::{PoseFormat, Posed, Target};
use super::photographs::Photographs;
use super::words::{Words, number};
use super::{found, names, posed, terms, whole};
use crate::base::shown::{short, shown};
use crate::base::{Error, Result};
use crate::scene::camera::{Camera, Distortion, Lens, Projection};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// Pix4D's calibrated cameras.
pub(crate) const PIX4D: PoseFormat = PoseFormat {
    name: "pix4d",
    programs: "Pix4Dmapper",
    target: Target::Either,
    advice: "name *_calibrated_camera_parameters.txt or the folder that holds it (1_initial/params)",
    is_at: |path| {
        let is = |file: PathBuf| whole::start_text(&file, 128).starts_with("fileName imageWidth imageHeight");
        file(path).is_some_and(is)
    },
    missing: |path| found::missing(path, file(path).is_some(), "must hold *_calibrated_camera_parameters.txt"),
    read,
};

fn file(path: &Path) -> Option<PathBuf> {
    if path.is_file() {
        return Some(path.to_owned());
    }
    let folders = [path.to_owned(), path.join("params"), path.join("1_initial/params")];
    folders.iter().find_map(|folder| found::ending(folder, &["calibrated_camera_parameters.txt"]).into_iter().next())
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no *_calibrated_camera_parameters.txt is there"))?;
    let text = whole::text(&file)?;
    let shots = shots(&text).map_err(|why| Error::malformed(&file, why))?;
    let written: Vec<String> = shots.iter().map(|shot| shot.name.clone()).collect();
    let mut frames: Vec<Frame> = Vec::with_capacity(shots.len());
    for (shot, name) in shots.into_iter().zip(names::settled(&written, photographs)?) {
        let same = frames.last().map(|last| &last.camera).filter(|camera| ***camera == shot.camera);
        let camera = same.map_or_else(|| Arc::new(shot.camera.clone()), Arc::clone);
        frames.push(Frame { name, camera, pose: shot.pose });
    }
    let folder = file.parent().unwrap_or(Path::new(""));
    let offset = found::ending(folder, &["offset.xyz"]).into_iter().next().and_then(|offset| whole::text(&offset).ok());
    let note =
        offset.map(|offset| format!("coordinates are relative to the project's offset {}", short(offset.trim())));
    Ok(Posed { frames, notes: note.into_iter().collect(), ..Posed::default() })
}

struct Shot {
    name: String,
    camera: Camera,
    pose: Pose,
}

/// The images of a file.
fn shots(text: &str) -> Result<Vec<Shot>, String> {
    let mut words = Words::without_comments(text);
    let mut head = words.line().unwrap_or_default();
    if !head.starts_with("fileName imageWidth imageHeight") {
        return Err(format!("it begins with {}; fileName imageWidth imageHeight is needed", shown(head)));
    }
    // What follows is said up to the line of the camera model.
    while !head.starts_with("camera model") {
        head = words.line().ok_or("the file ends within its head")?;
    }
    let mut all = Vec::new();
    while let Some(line) = words.line() {
        let at = words.line_number();
        all.push(shot(line, &mut words).map_err(|why| format!("line {at}, image {}: {why}", shown(line)))?);
    }
    Ok(all)
}

fn shot(line: &str, words: &mut Words<'_>) -> Result<Shot, String> {
    let mut from_end = line.rsplitn(3, char::is_whitespace);
    let (height, width, name) = (from_end.next(), from_end.next(), from_end.next());
    let (Some(height), Some(width), Some(name)) = (height, width, name) else {
        return Err("a name, a width and a height are needed".to_owned());
    };
    let (width, height): (u64, u64) = (number(width, "the width")?, number(height, "the height")?);
    let [fx, skew, cx, zero, fy, cy, ..] = words.numbers::<9>("the camera matrix")?;
    terms::none("K[1][0]", zero)?;
    terms::negligible("skew", skew, skew * 0.5 * cy / fy)?;
    let radial = Distortion::radial(words.numbers::<3>("the radial distortion")?);
    let tangential = words.numbers("the tangential distortion")?;
    let centre = DVec3::from(words.numbers("the camera position")?);
    let rotation: DMat3 = posed::rows(words.numbers("the camera rotation")?);
    let projection = Projection::Perspective(Distortion { tangential, ..radial });
    let lens = Lens::new(DVec2::new(fx, fy), DVec2::new(cx, cy), projection)?;
    let pose = posed::at_centre(rotation, centre)?;
    Ok(Shot { name: name.trim().to_owned(), camera: Camera::new(width, height, lens)?, pose })
}
