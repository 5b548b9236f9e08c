//! Bundler's `bundle.out` and the list of its images (Bundler's manual, "Output format").
//!
//! ```text
//! # Bundle file v0.3
//! cameras points
//! f k1 k2, R (three rows), t      for each camera; f is 0 where a camera is not posed
//! ```
//!
//! A pose is world-to-camera with x right, y up, z back. Images are counted from their centre, so their sizes are read from
//! the images. The cameras are in the order of `list.txt`.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::format::{PoseFormat, Posed, Target};
use super::photographs::Photographs;
use super::posed::{self, Y_UP};
use super::words::Words;
use super::{found, names, whole};
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::images::Size;
use crate::scene::camera::{Camera, Distortion, Lens, Projection};
use crate::scene::frame::Frame;

/// Bundler's output.
pub(crate) const BUNDLER: PoseFormat = PoseFormat {
    name: "bundler",
    programs: "Bundler, and many that export to it",
    target: Target::Either,
    advice: "name bundle.out or the folder that holds it, with list.txt beside it",
    is_at: |path| file(path).is_some_and(|file| whole::start_text(&file, 64).starts_with("# Bundle file")),
    missing: |path| found::missing(path, file(path).is_some(), "must be bundle.out or hold it"),
    read,
};

fn file(path: &Path) -> Option<PathBuf> {
    found::named(path, &["bundle.out", "bundle/bundle.out", "bundler.out"])
}

/// The camera of an image; `None` where the image is not posed.
struct Seen {
    focal: f64,
    radial: [f64; 2],
    rotation: DMat3,
    translation: DVec3,
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no bundle.out is there"))?;
    let text = whole::text(&file)?;
    let seen = cameras(&text).map_err(|why| Error::malformed(&file, why))?;
    let written = list(&file)?;
    if written.len() != seen.len() {
        let found = format!("it has {} cameras, and list.txt names {} images", seen.len(), written.len());
        return Err(Error::malformed(&file, found));
    }
    let (mut frames, mut unposed) = (Vec::new(), Vec::new());
    for ((seen, written), name) in seen.iter().zip(&written).zip(names::settled(&written, photographs)?) {
        let Some(seen) = seen else {
            unposed.push(name);
            continue;
        };
        let fault = |why| Error::malformed(&file, format!("image {}: {why}", shown(written)));
        let camera = Arc::new(seen.camera(photographs.size(&name)?).map_err(fault)?);
        let pose = posed::moved(Y_UP * seen.rotation, Y_UP * seen.translation).map_err(fault)?;
        frames.push(Frame { name, camera, pose });
    }
    Ok(Posed { frames, unposed, ..Posed::default() })
}

impl Seen {
    fn camera(&self, Size { width, height }: Size) -> Result<Camera, String> {
        let centre = DVec2::new(width.into(), height.into()) * 0.5;
        let lens =
            Lens::new(DVec2::splat(self.focal), centre, Projection::Perspective(Distortion::radial(self.radial)))?;
        Camera::new(width.into(), height.into(), lens)
    }
}

/// The cameras of a file.
fn cameras(text: &str) -> Result<Vec<Option<Seen>>, String> {
    let mut words = Words::of(text);
    let count: u64 = words.number("the number of cameras")?;
    let _: u64 = words.number("the number of points")?;
    let mut all = Vec::new();
    for at in 0..count {
        let mut one = || -> Result<Option<Seen>, String> {
            let [focal, k1, k2] = words.numbers("the focal length")?;
            let rotation = posed::rows(words.numbers("the rotation")?);
            let translation = DVec3::from(words.numbers("the translation")?);
            Ok((focal != 0.0).then_some(Seen { focal, radial: [k1, k2], rotation, translation }))
        };
        all.push(one().map_err(|why| format!("camera {at} of {count}: {why}"))?);
    }
    Ok(all)
}

/// The names of the images, in the order of the cameras.
fn list(bundle: &Path) -> Result<Vec<String>> {
    let folder = bundle.parent().unwrap_or(Path::new(""));
    let beside = ["list.txt", "bundle.out.list.txt", "../list.txt"].map(|name| folder.join(name));
    let Some(list) = beside.iter().find(|list| list.is_file()) else {
        let found = "list.txt, which names the images in the order of the cameras, is not beside it: put it there";
        return Err(Error::malformed(bundle, found));
    };
    let text = whole::text(list)?;
    let lines = text.lines().map(str::trim).filter(|line| !line.is_empty());
    Ok(lines.map(|line| name_of(line).to_owned()).collect())
}

/// The name in a line, which may end in `0 focal`.
fn name_of(line: &str) -> &str {
    let Some((rest, focal)) = line.rsplit_once(char::is_whitespace) else { return line };
    match rest.rsplit_once(char::is_whitespace) {
        Some((name, "0")) if focal.parse::<f64>().is_ok() => name.trim_end(),
        _ => line,
    }
}
