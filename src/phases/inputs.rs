//! What the names and headers of the inputs tell of a run beforehand.

use std::collections::BTreeSet;
use std::path::Path;

use glam::DVec3;
use rayon::prelude::*;

use super::scene::LoadedScene;
use crate::codec::images::mask_path;
use crate::codec::poses::{PhotographFolder, Photographs};
use crate::config::Choice;
use crate::pipeline::{Pipeline, UpFrom};
use crate::scene::frame::Frame;
use crate::scene::georeference::Georeference;
use crate::scene::seen::{middle, share_seen};
use crate::scene::up::{By, Upright, middle as cameras};
use crate::stages::light::Mode;

/// How many names are told of many.
const TOLD: usize = 3;

/// How far level cameras may be from the way up of a coordinate reference system, degrees.
const LEANS: f64 = 15.0;

/// How many vertices of the mesh are tried.
const TRIED: usize = 512;

/// What the inputs of a pipeline look like.
#[derive(Debug, Clone, Default, PartialEq)]
pub(crate) struct Inputs {
    /// The number of posed photographs.
    pub frames: usize,
    /// The way up, if the scene tells it.
    pub up: Option<Upright>,
    /// Where on the earth the scene lies, if it is known.
    pub place: Option<Georeference>,
    /// The photographs, or their masks, whose headers cannot be read, each with the reason.
    pub unread: Vec<(String, String)>,
    /// What is doubtful, a line each.
    pub doubts: Vec<String>,
}

impl Inputs {
    /// Looks at a scene's inputs: at the header of every photograph and mask.
    pub(crate) fn of(pipeline: &Pipeline, scene: &LoadedScene) -> Inputs {
        let decode = scene.decode(pipeline);
        let unread: Vec<(String, String)> = scene
            .frames
            .par_iter()
            .filter_map(|frame| decode.need(frame).err().map(|why| (frame.name.clone(), why.to_string())))
            .collect();
        Inputs {
            frames: scene.frames.len(),
            up: up(pipeline),
            place: pipeline.scene.georeference(),
            unread,
            doubts: doubts(pipeline, scene),
        }
    }

    /// All that is to be told, a line each.
    pub(crate) fn lines(&self) -> Vec<String> {
        let Inputs { frames, up, place, unread, doubts } = self;
        let told = unread.iter().take(TOLD).map(|(name, why)| format!("  {name}: {why}"));
        let more = unread.len().saturating_sub(TOLD);
        let head = match unread.len() {
            0 => None,
            all if all == *frames => Some(format!("none of the {frames} photographs can be read:")),
            some => Some(format!("{some} of {frames} photographs cannot be read, and will be skipped:")),
        };
        let rest = (more > 0).then(|| format!("  and {more} more"));
        let up = up.filter(|up| !matches!(up.by, By::Unsure(_))).map(|up| up.to_string());
        let place = place.map(|place| format!("coordinates are {place}"));
        up.into_iter().chain(place).chain(head).chain(told).chain(rest).chain(doubts.iter().cloned()).collect()
    }
}

/// What is doubtful of a scene's inputs, a line each, as far as it is told without opening a photograph.
pub(super) fn doubts(pipeline: &Pipeline, scene: &LoadedScene) -> Vec<String> {
    let leaning = up(pipeline).filter(|up| matches!(up.by, By::Unsure(_))).map(|up| up.to_string());
    let (unposed, masks, coarse) = (unposed(pipeline, scene), masks(pipeline, scene), scene.mesh.coarse());
    [apart(scene), leaning, elsewhere(pipeline, scene), scene.assumed.clone(), unposed, masks, coarse, sun(pipeline)]
        .into_iter()
        .flatten()
        .collect()
}

/// Tells of a mesh that no camera sees.
fn apart(scene: &LoadedScene) -> Option<String> {
    let (mesh, frames) = (&scene.mesh, &scene.frames);
    let step = mesh.positions.len().div_ceil(TRIED).max(1);
    let points: Vec<DVec3> = mesh.positions.iter().step_by(step).map(|at| at.as_dvec3() + mesh.origin).collect();
    if share_seen(frames, &points) > 0.0 {
        return None;
    }
    let centres: Vec<DVec3> = frames.iter().map(|frame| frame.pose.centre()).collect();
    let (lies, stand) = (middle(&[mesh.origin]), middle(&centres));
    Some(format!(
        "no camera has the mesh before it: it lies about {lies}, and they stand about {stand}; both must be in the same coordinates"
    ))
}

/// Tells of cameras that cannot stand where the coordinate reference system would have them, or that contradict its way up.
fn elsewhere(pipeline: &Pipeline, scene: &LoadedScene) -> Option<String> {
    let (place, frames) = (pipeline.scene.georeference()?, &scene.frames);
    let at = cameras(frames);
    if let Some(doubt) = place.doubt(at) {
        return Some(format!("by [scene] crs and offset the cameras stand about {doubt}: one of the two is another"));
    }
    let (up, level) = (place.up(at)?, Upright::of(frames, || None).filter(|up| matches!(up.by, By::Rows(_)))?);
    let degrees = up.angle_between(level.up.into()).to_degrees();
    (up_from_system(pipeline) && degrees > LEANS).then(|| {
        format!("{level}: {degrees:.0} degrees from that of {place}; if the mesh lies in other coordinates, take [scene] crs out")
    })
}

/// Whether the way up is that of the coordinate reference system.
fn up_from_system(pipeline: &Pipeline) -> bool {
    up(pipeline).is_some_and(|up| up.by == By::System)
}

/// Tells of photographs without a pose.
fn unposed(pipeline: &Pipeline, scene: &LoadedScene) -> Option<String> {
    let posed: BTreeSet<&str> = scene.frames.iter().chain(&scene.held_out).map(|frame| frame.name.as_str()).collect();
    let photographs = PhotographFolder::new(&pipeline.scene.images);
    let files = photographs.names().unwrap_or_default();
    let is_mask = |file: &str| pipeline.scene.masks.as_ref() == Some(&pipeline.scene.images) && file.contains("mask");
    let without: Vec<&String> = files.iter().filter(|file| !posed.contains(file.as_str()) && !is_mask(file)).collect();
    let first: Vec<&str> = without.iter().take(TOLD).map(|name| name.as_str()).collect();
    let more = if without.len() > TOLD { ", ..." } else { "" };
    (!without.is_empty()).then(|| {
        format!(
            "{} of {} photographs in the folder have no pose: {}{more}",
            without.len(),
            files.len(),
            first.join(", ")
        )
    })
}

/// Tells of masks that are not there.
fn masks(pipeline: &Pipeline, scene: &LoadedScene) -> Option<String> {
    let (masks, images) = (pipeline.scene.masks.as_ref()?, &pipeline.scene.images);
    let is_bare = |frame: &&Frame| !matches!(mask_path(masks, images, &frame.name), Ok(Some(_)));
    let bare: Vec<&Frame> = scene.frames.par_iter().filter(is_bare).collect();
    let (all, with, first) = (scene.frames.len(), scene.frames.len() - bare.len(), bare.first()?);
    let stem = Path::new(&first.name).with_extension("");
    let (name, stem, folder) = (&first.name, stem.display(), masks.display());
    let head = if with == 0 {
        "no photograph has a mask".to_owned()
    } else {
        format!("{with} of {all} photographs have a mask")
    };
    Some(format!(
        "{head} in {folder}: for {name}, {name}.png, {stem}.png, {stem}_mask.png and {stem}.mask.png were looked for, as .jpg and .tif \
         too; every pixel counts where there is none"
    ))
}

/// The way up, if the scene tells it.
pub(super) fn up(pipeline: &Pipeline) -> Option<Upright> {
    if let UpFrom::Scene(found) = pipeline.scene.up_from { found } else { None }
}

/// Tells of a sun below the horizon.
fn sun(pipeline: &Pipeline) -> Option<String> {
    let (light, up) = (&pipeline.light, pipeline.scene.up);
    let (sun, up) = (DVec3::from(light.sun).normalize_or_zero(), DVec3::from(up).normalize_or_zero());
    let elevation = sun.dot(up).clamp(-1.0, 1.0).asin().to_degrees();
    (light.mode == Mode::Known && elevation < 0.0).then(|| {
        format!(
            "[light] sun stands {:.0} degrees below the horizon, by [scene] up: sun points towards the sun, not from it, where mode = \
             \"{}\"",
            -elevation,
            light.mode.name()
        )
    })
}
