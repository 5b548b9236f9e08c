//! The format `opensfm`: `reconstruction.json`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::Deserialize;

use super::lens::{LensOf, Lenses};
use super::rigs::{Instance, Rigs, Turned};
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::poses::format::{PoseFormat, Posed, Target};
use crate::codec::poses::photographs::Photographs;
use crate::codec::poses::{found, json, names, whole};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// OpenSfM's reconstruction.
pub(crate) const OPENSFM: PoseFormat = PoseFormat {
    name: "opensfm",
    programs: "OpenSfM, OpenDroneMap",
    target: Target::Either,
    advice: "name reconstruction.json or the folder that holds it",
    is_at: |path| file(path).is_some_and(|file| is_one(&whole::start_text(&file, 1 << 16))),
    missing: |path| found::missing(path, file(path).is_some(), "must be reconstruction.json or hold it"),
    read,
};

fn file(path: &Path) -> Option<PathBuf> {
    found::named(path, &["reconstruction.json", "opensfm/reconstruction.json", "reconstruction.meshed.json"])
}

/// Whether a file that begins so is a list of reconstructions.
fn is_one(text: &str) -> bool {
    text.trim_start().starts_with('[') && text.contains("\"cameras\"")
}

/// What is read of a reconstruction.
#[derive(Debug, Deserialize)]
struct Reconstruction {
    cameras: BTreeMap<String, LensOf>,
    shots: BTreeMap<String, Shot>,
    #[serde(default)]
    rig_cameras: BTreeMap<String, Turned>,
    #[serde(default)]
    rig_instances: BTreeMap<String, Instance>,
}

#[derive(Debug, Deserialize)]
struct Shot {
    camera: String,
    rotation: Option<[f64; 3]>,
    translation: Option<[f64; 3]>,
}

impl Shot {
    fn pose(&self, name: &str, rigs: &Rigs<'_>) -> Result<Pose, String> {
        match (self.rotation, self.translation) {
            (Some(rotation), Some(translation)) => Turned { rotation, translation }.pose(),
            _ => rigs.pose(name)?.ok_or_else(|| "it has neither a pose nor a rig that has one".to_owned()),
        }
    }
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no reconstruction.json is there"))?;
    let mut all: Vec<Reconstruction> = json::read(&file)?;
    let fault = |why: String| Error::malformed(&file, why);
    // The first of the largest.
    let most = all.iter().map(|one| one.shots.len()).max().unwrap_or_default();
    let at = all.iter().position(|one| one.shots.len() == most);
    let one = at.map(|at| all.remove(at)).ok_or_else(|| fault("it holds no reconstruction".to_owned()))?;
    let (mut lenses, rigs) = (Lenses::of(&one.cameras), Rigs::of(&one.rig_instances, &one.rig_cameras));
    let written: Vec<String> = one.shots.keys().cloned().collect();
    let mut frames = Vec::with_capacity(written.len());
    for ((as_written, shot), name) in one.shots.iter().zip(names::settled(&written, photographs)?) {
        let fault = |why| fault(format!("shot {}: {why}", shown(as_written)));
        let pose = shot.pose(as_written, &rigs).map_err(fault)?;
        frames.push(Frame { name, camera: lenses.get(&shot.camera).map_err(fault)?, pose });
    }
    let others: Vec<String> = all.iter().flat_map(|other| other.shots.keys().cloned()).collect();
    let (more, shots) = (all.len(), others.len());
    let note =
        format!("{more} more reconstructions, of {shots} shots, are in coordinates of their own and are not read");
    let notes = if more == 0 { Vec::new() } else { vec![note] };
    Ok(Posed { frames, unposed: others, notes, ..Posed::default() })
}
