//! The format `opendronemap`: the folder of a project or of a WebODM download.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use glam::DVec3;
use serde::Deserialize;

use super::offset;
use crate::base::shown::{short, shown};
use crate::base::{Error, Result};
use crate::codec::poses::format::{PoseFormat, Posed, Target};
use crate::codec::poses::opensfm::{LensOf, Lenses};
use crate::codec::poses::photographs::Photographs;
use crate::codec::poses::{found, json, names, posed};
use crate::scene::frame::Frame;
use crate::scene::georeference::Georeference;

/// OpenDroneMap's results.
pub(crate) const OPENDRONEMAP: PoseFormat = PoseFormat {
    name: "opendronemap",
    programs: "OpenDroneMap, WebODM",
    target: Target::Folder,
    advice: "name the folder that holds cameras.json and odm_report/shots.geojson",
    is_at: |path| path.is_dir() && shots(path).is_some() && cameras(path).is_some(),
    missing: |path| {
        let there = shots(path).is_some() && cameras(path).is_some();
        found::missing(path, there, "must hold cameras.json and odm_report/shots.geojson")
    },
    read,
};

fn cameras(project: &Path) -> Option<PathBuf> {
    found::named(project, &["cameras.json"])
}

fn shots(project: &Path) -> Option<PathBuf> {
    found::named(project, &["odm_report/shots.geojson", "shots.geojson"])
}

#[derive(Debug, Deserialize)]
struct Shots {
    features: Vec<Feature>,
}

#[derive(Debug, Deserialize)]
struct Feature {
    properties: Shot,
}

#[derive(Debug, Deserialize)]
struct Shot {
    filename: String,
    /// OpenSfM's id of the camera, which newer versions write.
    camera: Option<String>,
    focal: Option<f64>,
    width: u64,
    height: u64,
    rotation: [f64; 3],
    /// The camera's centre.
    translation: [f64; 3],
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let there = |file: Option<PathBuf>, name| file.ok_or_else(|| Error::malformed(path, format!("no {name} is there")));
    let (shots_file, cameras_file) =
        (there(shots(path), "odm_report/shots.geojson")?, there(cameras(path), "cameras.json")?);
    let written: BTreeMap<String, LensOf> = json::read(&cameras_file)?;
    let shots: Shots = json::read(&shots_file)?;
    let offset = offset::read(path)?;
    let origin = offset.as_ref().map_or(DVec3::ZERO, |offset| offset.at);
    let mut lenses = Lenses::of(&written);
    let names: Vec<String> = shots.features.iter().map(|feature| feature.properties.filename.clone()).collect();
    let mut frames = Vec::with_capacity(names.len());
    for (Feature { properties: shot }, name) in shots.features.iter().zip(names::settled(&names, photographs)?) {
        let fault = |why| Error::malformed(&shots_file, format!("shot {}: {why}", shown(&shot.filename)));
        let camera = lenses.get(camera_of(shot, &written).map_err(fault)?).map_err(fault)?;
        let turned = posed::about(shot.rotation.into()).map_err(fault)?;
        let pose = posed::at_centre(turned, DVec3::from(shot.translation) - origin).map_err(fault)?;
        frames.push(Frame { name, camera, pose });
    }
    let georeference = offset
        .as_ref()
        .map(|offset| Georeference { crs: offset.projection.parse().ok(), offset: offset.at.to_array() });
    let note = offset.map(|offset| {
        let (DVec3 { x, y, .. }, projection) = (offset.at, short(&offset.projection));
        format!("coordinates are {projection} minus the offset {x} {y} of the project's meshes")
    });
    Ok(Posed { frames, georeference, notes: note.into_iter().collect(), ..Posed::default() })
}

/// The id of a shot's camera: the one it names, or the one of its size and focal length.
fn camera_of<'a>(shot: &'a Shot, cameras: &'a BTreeMap<String, LensOf>) -> Result<&'a str, String> {
    if let Some(id) = shot.camera.as_deref() {
        return Ok(id);
    }
    let sized: Vec<(&String, &LensOf)> =
        cameras.iter().filter(|(_, lens)| lens.is_of(shot.width, shot.height)).collect();
    let off = |lens: &LensOf| shot.focal.map_or(0.0, |focal| (lens.focal() - focal).abs());
    let least = sized.iter().map(|(_, lens)| off(lens)).fold(f64::INFINITY, f64::min);
    let near: Vec<&str> =
        sized.iter().filter(|(_, lens)| off(lens) <= least + 1e-9).map(|(id, _)| id.as_str()).collect();
    match near[..] {
        [one] => Ok(one),
        [] => Err(format!("no camera of cameras.json is of {} x {} pixels", shot.width, shot.height)),
        [one, other, ..] => Err(format!("its camera may be {} or {}", shown(one), shown(other))),
    }
}
