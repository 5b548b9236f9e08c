//! `gonio poses`: what posed photographs hold, and their way to COLMAP.

use std::collections::BTreeSet;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;

use super::ending::{Answer, Ending, Failure};
use super::print::{Lines, err, out};
use crate::base::{Error, Result};
use crate::codec::poses::colmap::{Encoding, with_lenses_of_colmap, write_model};
use crate::codec::poses::{self, FORMATS, PhotographFolder, Photographs, PoseFormat};
use crate::pipeline::load;
use crate::scene::frame::Frame;

/// Options of `poses`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The file or folder that holds the poses, or a pipeline file that names them
    #[arg(value_name = "PATH")]
    path: PathBuf,
    /// The format, where the files do not tell: colmap, opendronemap, opensfm, metashape, ... (docs/formats.md)
    #[arg(long, value_name = "NAME")]
    format: Option<String>,
    /// The folder of the photographs; by default a folder named images, or that of the poses
    #[arg(long, value_name = "FOLDER")]
    images: Option<PathBuf>,
    /// Write the poses as a COLMAP text model into this folder
    #[arg(long, value_name = "FOLDER")]
    colmap: Option<PathBuf>,
}

/// The most names that are shown of a list.
const SHOWN: usize = 5;

/// Says what posed photographs hold.
pub(super) fn poses(args: &Args) -> Answer {
    let Source { format, path, images } = source(args)?;
    let photographs = PhotographFolder::new(&images);
    let posed = poses::look(format, &path, &photographs)?;
    let mut lines = Lines::default();
    lines.add(format!("{}: {} ({})", path.display(), format.name, format.programs));
    lines.row("frames", format!("{} with a pose", posed.frames.len()));
    add_names(&mut lines, "no pose", &posed.unposed);
    add_lenses(&mut lines, &posed.frames);
    add_centres(&mut lines, &posed.frames);
    let there: BTreeSet<&str> = photographs.names()?.iter().map(String::as_str).collect();
    let missing = posed.frames.iter().map(|frame| frame.name.clone()).filter(|name| !there.contains(name.as_str()));
    add_names(&mut lines, "no photograph", &missing.collect::<Vec<_>>());
    lines.row("photographs", format!("{} in {}", there.len(), images.display()));
    posed.georeference.iter().for_each(|place| lines.row("coordinates", place.to_string()));
    posed.notes.iter().for_each(|note| lines.row("note", note.clone()));
    if let Some(folder) = &args.colmap {
        let off = write(folder, &posed.frames)?;
        let how = if off > 0.0 { format!(", lenses within {off:.1e} pixels of their own") } else { String::new() };
        lines.row("written", format!("{}: a COLMAP text model{how}", folder.display()));
    }
    out(&lines.finish())?;
    Ok(Ending::Done)
}

/// Where the poses and the photographs are.
struct Source {
    format: &'static PoseFormat,
    path: PathBuf,
    images: PathBuf,
}

fn source(args: &Args) -> Result<Source, Failure> {
    if args.path.extension().is_some_and(|ending| ending == "toml") {
        let scene = load(&args.path, &[])?.scene;
        let images = args.images.clone().unwrap_or(scene.images);
        return Ok(Source { format: scene.poses.format, path: scene.poses.path, images });
    }
    let path = args.path.clone();
    fs::metadata(&path).map_err(Error::io("open", &path))?;
    let format = match &args.format {
        Some(name) => named(name)?,
        None => found(&path)?,
    };
    let folder = if path.is_dir() { path.as_path() } else { path.parent().unwrap_or(Path::new("")) };
    let usual = [folder.join("images"), folder.join("../images"), folder.join("../../images")];
    let beside = || usual.into_iter().find(|images| images.is_dir()).unwrap_or_else(|| folder.to_owned());
    let images = args.images.clone().unwrap_or_else(beside);
    Ok(Source { format, path, images })
}

fn known() -> String {
    FORMATS.iter().map(|format| format.name).collect::<Vec<_>>().join(", ")
}

fn named(name: &str) -> Result<&'static PoseFormat> {
    let found = FORMATS.iter().copied().find(|format| format.name == name);
    found.ok_or_else(|| Error::invalid(format!("--format {name:?} is not known; these are: {}", known())))
}

/// The format of what lies at a path.
fn found(path: &Path) -> Result<&'static PoseFormat> {
    match poses::formats_at(path)[..] {
        [] => {
            Err(Error::malformed(path, format!("no poses that gonio reads; name the format by --format: {}", known())))
        }
        [one] => Ok(one),
        [one, ref others @ ..] => {
            let others: Vec<&str> = others.iter().map(|format| format.name).collect();
            err(&format!("read as {}; it is also {}: --format chooses", one.name, others.join(", ")));
            Ok(one)
        }
    }
}

fn add_names(lines: &mut Lines, what: &str, names: &[String]) {
    if !names.is_empty() {
        let first: Vec<&str> = names.iter().take(SHOWN).map(String::as_str).collect();
        let more = if names.len() > SHOWN { ", ..." } else { "" };
        lines.row(what, format!("{}: {}{more}", names.len(), first.join(", ")));
    }
}

fn add_lenses(lines: &mut Lines, frames: &[Frame]) {
    let mut all: Vec<(&Arc<crate::scene::camera::Camera>, usize)> = Vec::new();
    for Frame { camera, .. } in frames {
        match all.iter().position(|(known, _)| *known == camera) {
            Some(at) => all[at].1 += 1,
            None => all.push((camera, 1)),
        }
    }
    for (camera, count) in all.iter().take(SHOWN) {
        let (focal, centre) = (camera.lens.focal(), camera.lens.centre());
        lines.row("lens", {
            format!(
                "{} x {}, focal lengths {:.2} {:.2}, principal point {:.2} {:.2}, {count} frames",
                camera.width, camera.height, focal.x, focal.y, centre.x, centre.y
            )
        });
    }
    if all.len() > SHOWN {
        lines.row("lenses", format!("{} in all", all.len()));
    }
}

fn add_centres(lines: &mut Lines, frames: &[Frame]) {
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for frame in frames {
        let centre = frame.pose.centre();
        (low, high) = (low.min(centre), high.max(centre));
    }
    let shown = |at: DVec3| format!("{:.3} {:.3} {:.3}", at.x, at.y, at.z);
    lines.row("centres", format!("{} to {}", shown(low), shown(high)));
}

/// Writes the model; gives by how many pixels the worst lens differs from its own.
fn write(folder: &Path, frames: &[Frame]) -> Result<f64> {
    let (frames, off) = with_lenses_of_colmap(frames)?;
    fs::create_dir_all(folder).map_err(Error::io("create", folder))?;
    write_model(folder, &frames, Encoding::Text)?;
    Ok(off)
}
