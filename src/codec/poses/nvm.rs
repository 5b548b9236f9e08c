//! VisualSFM's `.nvm` (VisualSFM's documentation, "NVM file format").
//!
//! ```text
//! NVM_V3 [FixedK fx cx fy cy]
//! cameras
//! name f qw qx qy qz cx cy cz r 0      for each camera: a world-to-camera quaternion and the camera's centre
//! ```
//!
//! Axes are ours. The one radial term says the way back: `ideal = d (1 + r |d|^2 / f^2)`, with d from the image's centre. Of
//! several models in a file, the first is read.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DQuat, DVec2, DVec3};

use super::format::{PoseFormat, Posed, Target};
use super::photographs::Photographs;
use super::words::{Words, exactly};
use super::{found, names, posed, whole};
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::images::Size;
use crate::scene::camera::{Camera, Distortion, Lens, Projection};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// VisualSFM's model.
pub(crate) const NVM: PoseFormat = PoseFormat {
    name: "nvm",
    programs: "VisualSFM",
    target: Target::Either,
    advice: "name the .nvm file or the folder that holds it",
    is_at: |path| file(path).is_some_and(|file| is_one(&file)),
    missing: |path| found::missing(path, file(path).is_some(), "must be an .nvm file or hold one"),
    read,
};

fn file(path: &Path) -> Option<PathBuf> {
    found::told(path, &[".nvm"], is_one)
}

fn is_one(file: &Path) -> bool {
    whole::start_text(file, 16).starts_with("NVM_V")
}

/// A camera as its line has it.
struct Line<'a> {
    name: &'a str,
    focal: f64,
    quaternion: [f64; 4],
    centre: [f64; 3],
    radial: f64,
}

/// What the first line says of all lenses: fx, cx, fy, cy.
type Fixed = Option<[f64; 4]>;

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no .nvm file is there"))?;
    let text = whole::text(&file)?;
    let (fixed, lines) = lines(&text).map_err(|why| Error::malformed(&file, why))?;
    let written: Vec<String> = lines.iter().map(|line| line.name.to_owned()).collect();
    let mut frames = Vec::with_capacity(lines.len());
    for (line, name) in lines.iter().zip(names::settled(&written, photographs)?) {
        let fault = |why| Error::malformed(&file, format!("image {}: {why}", shown(line.name)));
        let camera = Arc::new(line.camera(fixed, photographs.size(&name)?).map_err(fault)?);
        frames.push(Frame { name, camera, pose: line.pose().map_err(fault)? });
    }
    Ok(frames.into())
}

impl Line<'_> {
    fn camera(&self, fixed: Fixed, Size { width, height }: Size) -> Result<Camera, String> {
        let middle = DVec2::new(width.into(), height.into()) * 0.5;
        let (focal, centre) = match fixed {
            Some([fx, cx, fy, cy]) => (DVec2::new(fx, fy), DVec2::new(cx, cy)),
            None => (DVec2::splat(self.focal), middle),
        };
        let projection = match self.radial {
            0.0 => Projection::Pinhole,
            radial => Projection::Inward(Distortion::radial([radial])),
        };
        Camera::new(width.into(), height.into(), Lens::new(focal, centre, projection)?)
    }

    fn pose(&self) -> Result<Pose, String> {
        let [w, x, y, z] = self.quaternion;
        let turned = DQuat::from_xyzw(x, y, z, w);
        if turned.length() < 1e-6 {
            return Err(format!("the quaternion of its rotation is {:?}; its length must not be 0", self.quaternion));
        }
        posed::at_centre(DMat3::from_quat(turned.normalize()), DVec3::from(self.centre))
    }
}

/// The cameras of the first model.
fn lines(text: &str) -> Result<(Fixed, Vec<Line<'_>>), String> {
    let mut words = Words::without_comments(text);
    let head = words.line().unwrap_or_default();
    let rest = match head.split_once(char::is_whitespace).unwrap_or((head, "")) {
        ("NVM_V3", rest) => rest.trim(),
        (other, _) => return Err(format!("line 1: the version is {}; NVM_V3 is read", shown(other))),
    };
    let fixed = match rest.strip_prefix("FixedK") {
        Some(numbers) => Some(exactly(numbers, "FixedK")?),
        None => None,
    };
    let count: u64 = words.number("the number of cameras")?;
    let mut all = Vec::new();
    for at in 0..count {
        let line = words.line().ok_or_else(|| format!("camera {at} of {count}: the file ends within it"))?;
        all.push(one(line).map_err(|why| format!("line {}: {why}", words.line_number()))?);
    }
    Ok((fixed, all))
}

/// A camera's line. A name may have blanks: the ten numbers are what stands at the end.
fn one(line: &str) -> Result<Line<'_>, String> {
    let mut name = line;
    for _ in 0..10 {
        let cut = name.trim_end().rsplit_once(char::is_whitespace);
        name = cut.ok_or("a name and ten numbers are needed")?.0;
    }
    let [focal, w, x, y, z, cx, cy, cz, radial, _] = exactly(&line[name.len()..], "a camera")?;
    let name = name.trim().trim_matches('"');
    Ok(Line { name, focal, quaternion: [w, x, y, z], centre: [cx, cy, cz], radial })
}
