//! What was found in a project's folder: what is told of it, and the values of its pipeline file.

use std::cmp::Reverse;
use std::path::{Path, PathBuf};

use super::cameras::{self, Cameras};
use super::flight;
use super::listing::{Listing, named};
use super::masks::{self, Masks};
use super::photographs::{Fit, Photographs};
use super::surface::{self, Surfaces};
use super::usual::{self, IMAGES, MESH, POSES};
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::codec::images::is_picture;
use crate::pipeline::{Filled, told};
use crate::scene::camera::{Camera, Projection};
use crate::scene::frame::Frame;
use crate::scene::up::Upright;

/// The most names that are told of many.
const TOLD: usize = 3;

/// The most lenses that are told apart.
const MANY: usize = 64;

/// What was found in a project's folder.
#[derive(Debug)]
pub(crate) struct Found {
    /// The folder.
    pub(super) root: PathBuf,
    pub(super) listing: Listing,
    /// The poses, with the photographs that were found for them; the first are those that are taken.
    pub(super) posed: Vec<(Cameras, Option<Photographs>)>,
    /// What is said of poses that cannot be read.
    pub(super) broken: Vec<String>,
    pub(super) masks: Option<Masks>,
    pub(super) surfaces: Surfaces,
}

impl Found {
    /// Looks at a folder.
    ///
    /// # Errors
    /// No such folder; one in which there is nothing that gonio knows.
    pub(crate) fn at(root: &Path) -> Result<Found> {
        if root.is_file() {
            return Err(Error::invalid(format!("{} is a file: name the folder of a project", root.display())));
        }
        let listing = Listing::of(root)?;
        let (mut posed, broken) = cameras::find(root, &listing);
        posed.sort_by_cached_key(|(_, photographs)| Rank::of(photographs.as_ref()));
        let taken = posed.first().and_then(|(_, photographs)| photographs.as_ref());
        let masks = taken.and_then(|photographs| masks::find(root, &listing, photographs));
        let surfaces = surface::find(root, &listing, posed.first().map(|(cameras, _)| cameras));
        let pictures = listing.files.iter().any(|file| is_picture(Path::new(file)));
        if posed.is_empty() && broken.is_empty() && surfaces.meshes.is_empty() && !pictures {
            let words = format!(
                "{} holds neither poses nor photographs nor a mesh: name the folder of a project\n{}",
                root.display(),
                usual::formats()
            );
            return Err(Error::invalid(words));
        }
        Ok(Found { root: root.to_owned(), listing, posed, broken, masks, surfaces })
    }

    /// The poses that are taken.
    pub(super) fn cameras(&self) -> Option<&Cameras> {
        self.posed.first().map(|(cameras, _)| cameras)
    }

    /// The photographs that are taken.
    pub(super) fn photographs(&self) -> Option<&Photographs> {
        self.posed.first().and_then(|(_, photographs)| photographs.as_ref())
    }

    /// The mesh that is taken.
    pub(super) fn mesh(&self) -> Option<&str> {
        self.surfaces.meshes.first().map(|mesh| mesh.file.as_str())
    }

    /// What was found, a line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        let mut lines = Vec::new();
        let mut tell = |name: &str, words: String| lines.push(format!("{name:12} {words}"));
        if let Some(cameras) = self.cameras() {
            tell("poses", format!("{}: {}", named(&cameras.path), described(cameras)));
            tell("lens", lensed(&cameras.frames));
            let ground = || self.surfaces.meshes.first().map(|mesh| mesh.points.clone());
            cameras.notes.iter().for_each(|note| tell("", note.clone()));
            let mesh = self.root.join(self.mesh().unwrap_or_default());
            let place = told(cameras.place, &self.root.join(&cameras.path), &mesh);
            if let Some(place) = place {
                tell("coordinates", place.to_string());
            }
            let up = Upright::in_system(place, &cameras.frames).or_else(|| Upright::of(&cameras.frames, ground));
            if let Some(up) = up {
                tell("axes", up.to_string());
            }
        }
        if let Some(others) = others(self.posed.iter().map(|(cameras, _)| named(&cameras.path))) {
            tell("", others);
        }
        if let (Some(found), Some(cameras)) = (self.photographs(), self.cameras()) {
            tell("photographs", photographed(found, cameras));
            flight::lines(&self.root, found).into_iter().for_each(|(name, words)| tell(name, words));
        }
        if let (Some(Masks { folder, count }), Some(found)) = (&self.masks, self.photographs()) {
            tell("masks", format!("{}: {count} of {} photographs have one", named(folder), found.count()));
        }
        if let Some(mesh) = self.surfaces.meshes.first() {
            let seen = mesh.seen.map(|seen| format!(", {:.0}% of it before the cameras", 100.0 * seen));
            let parts = if mesh.parts > 1 { format!(", {} files", mesh.parts) } else { String::new() };
            tell("mesh", format!("{}{parts}, {}{}", mesh.file, Bytes(mesh.bytes), seen.unwrap_or_default()));
        }
        if let Some(others) = others(self.surfaces.meshes.iter().map(|mesh| mesh.file.as_str())) {
            tell("", others);
        }
        if self.listing.cut {
            tell("", "the folder holds more than was looked at".to_owned());
        }
        lines
    }

    /// The values of the pipeline file.
    pub(super) fn values(&self) -> Vec<Filled> {
        let path = |key, path: &str| Filled { key, value: quoted(named(path)), note: None };
        let guess = |key, guess: &str, what: &str| {
            let note = format!("NOT FOUND: {what} is missing; this is where it is looked for.");
            Filled { note: Some(note), ..path(key, guess) }
        };
        let (cameras, photographs) = (self.cameras(), self.photographs());
        let mut values = vec![
            self.mesh().map_or_else(|| guess("scene.mesh", MESH, "the mesh"), |mesh| path("scene.mesh", mesh)),
            photographs.map_or_else(
                || guess("scene.images", IMAGES, "the folder of the photographs"),
                |found| path("scene.images", &found.folder),
            ),
            cameras.map_or_else(
                || guess("scene.poses.path", POSES, "the reconstruction"),
                |cameras| path("scene.poses.path", &cameras.path),
            ),
            path("run.work", "gonio"),
        ];
        values.extend(cameras.map(|cameras| path("scene.poses.format", cameras.format.name)));
        values.extend(self.masks.as_ref().map(|masks| path("scene.masks", &masks.folder)));
        if let Some(Photographs { fit: Fit::Smaller(by @ 2..), .. }) = photographs {
            let note = format!("The photographs are {by} times smaller than the cameras of the poses.");
            values.push(Filled { key: "decode.downscale", value: by.to_string(), note: Some(note) });
        }
        values
    }
}

/// The order of poses: those with the most photographs, then those whose sizes fit best, then those whose photographs are
/// nearest: what is undistorted lies deeper than what it was made from, and has less of it.
#[derive(PartialEq, Eq, PartialOrd, Ord)]
struct Rank(Reverse<usize>, Option<Fit>, usize);

impl Rank {
    fn of(photographs: Option<&Photographs>) -> Rank {
        let count = photographs.map_or(0, Photographs::count);
        let depth = photographs.map_or(0, |found| found.folder.matches('/').count());
        Rank(Reverse(count), photographs.map(|found| found.fit.clone()), depth)
    }
}

/// The format, the frames and the sizes of cameras.
fn described(cameras: &Cameras) -> String {
    let mut sizes: Vec<[u32; 2]> = cameras.frames.iter().map(|f| [f.camera.width, f.camera.height]).collect();
    sizes.sort_unstable();
    sizes.dedup();
    let told: Vec<String> = sizes.iter().take(TOLD).map(|[w, h]| format!("{w} x {h}")).collect();
    let more = if sizes.len() > TOLD { ", ..." } else { "" };
    let (name, programs) = (cameras.format.name, cameras.format.programs);
    format!("{name} ({programs}), {} frames of {}{more} pixels", cameras.frames.len(), told.join(", "))
}

/// The lenses: how many there are, and what the first does.
fn lensed(frames: &[Frame]) -> String {
    let mut lenses: Vec<&Camera> = Vec::new();
    for Frame { camera, .. } in frames {
        if !lenses.contains(&&**camera) && lenses.len() < MANY {
            lenses.push(camera);
        }
    }
    let Some(first) = lenses.first() else { return String::new() };
    let kind = match first.lens.projection() {
        Projection::Pinhole => "without distortion",
        Projection::Perspective(_) => "with distortion",
        Projection::Inward(_) => "with distortion that says the way back",
        Projection::Equidistant(_) => "a fisheye",
        Projection::FieldOfView { .. } => "of the field-of-view model",
        Projection::Unified(_) => "of the unified model",
    };
    let count = match lenses.len() {
        1 => "one".to_owned(),
        MANY => format!("{MANY} or more, the first"),
        many => format!("{many}, the first"),
    };
    format!("{count} {kind}, of a focal length of {:.1} pixels", first.lens.focal().x)
}

/// The photographs, and how they go with the cameras.
fn photographed(found: &Photographs, cameras: &Cameras) -> String {
    let mut words = format!("{}: {} of {}", named(&found.folder), found.count(), cameras.frames.len());
    if let Some(alike) = found.alike {
        words.push_str(&format!(", found {alike}"));
    }
    let first = cameras.frames.iter().zip(&found.files).find(|(_, file)| file.is_none());
    if let Some((frame, _)) = first {
        words.push_str(&format!("; {} is not there", frame.name));
    }
    match &found.fit {
        Fit::Smaller(1) => {}
        Fit::Smaller(by) => words.push_str(&format!("; {by} times smaller than the cameras")),
        Fit::Not(why) => words.push_str(&format!("; the sizes do not fit: {why}")),
    }
    words
}

/// The names after the first that are other names.
fn others<'a>(mut names: impl Iterator<Item = &'a str>) -> Option<String> {
    let first = names.next()?;
    let others: Vec<&str> = names.filter(|name| *name != first).collect();
    let more = if others.len() > TOLD { ", ..." } else { "" };
    (!others.is_empty()).then(|| format!("there is also {}{more}", others[..others.len().min(TOLD)].join(", ")))
}

/// A text as TOML has it.
fn quoted(text: &str) -> String {
    toml::Value::String(text.to_owned()).to_string()
}
