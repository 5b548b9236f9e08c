//! The format `alicevision`: a `.sfm` file.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DVec3};
use serde::Deserialize;

use super::lens::Intrinsic;
use crate::base::convert::Cut;
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::poses::format::{PoseFormat, Posed, Target};
use crate::codec::poses::json::{self, Number, values};
use crate::codec::poses::photographs::Photographs;
use crate::codec::poses::{found, names, posed, whole};
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// AliceVision's and Meshroom's scene.
pub(crate) const ALICEVISION: PoseFormat = PoseFormat {
    name: "alicevision",
    programs: "AliceVision, Meshroom",
    target: Target::Either,
    advice: "name cameras.sfm or the folder that holds it",
    is_at: |path| file(path).is_some_and(|file| is_one(&file)),
    missing: |path| found::missing(path, file(path).is_some(), "must be a .sfm file or hold cameras.sfm"),
    read,
};

/// The newest major version whose lengths and turns are known.
const NEWEST: u64 = 1;

fn file(path: &Path) -> Option<PathBuf> {
    found::named(path, &["cameras.sfm", "sfm.sfm"]).or_else(|| found::told(path, &[".sfm"], is_one))
}

fn is_one(file: &Path) -> bool {
    whole::start_text(file, 1 << 16).contains("\"viewId\"")
}

#[derive(Debug, Deserialize)]
struct Scene {
    version: [Number; 3],
    #[serde(default)]
    views: Vec<View>,
    #[serde(default)]
    intrinsics: Vec<Intrinsic>,
    #[serde(default)]
    poses: Vec<PoseOf>,
    #[serde(default)]
    rigs: Vec<Rig>,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct View {
    pose_id: Option<String>,
    intrinsic_id: Option<String>,
    rig_id: Option<String>,
    sub_pose_id: Option<Number>,
    is_pose_independant: Option<String>,
    path: String,
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct PoseOf {
    pose_id: String,
    pose: Locked,
}

#[derive(Debug, Deserialize)]
struct Locked {
    transform: Transform,
}

#[derive(Debug, Deserialize)]
struct Transform {
    rotation: [Number; 9],
    center: [Number; 3],
}

#[derive(Debug, Deserialize)]
#[serde(rename_all = "camelCase")]
struct Rig {
    rig_id: String,
    sub_poses: Vec<SubPose>,
}

#[derive(Debug, Deserialize)]
struct SubPose {
    pose: Transform,
}

impl Transform {
    fn pose(&self) -> Result<Pose, String> {
        let to_world = posed::rows(values(self.rotation));
        posed::at_centre(to_world.transpose(), DVec3::from(values(self.center)))
    }
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no .sfm file is there"))?;
    let scene: Scene = json::read(&file)?;
    let version = values(scene.version).map(u64::cut);
    if version[0] > NEWEST {
        let [major, minor, patch] = version;
        let found = format!("it is of version {major}.{minor}.{patch}; versions up to {NEWEST} are read");
        return Err(Error::malformed(&file, found));
    }
    let poses: BTreeMap<&str, &Transform> =
        scene.poses.iter().map(|one| (one.pose_id.as_str(), &one.pose.transform)).collect();
    let written: Vec<String> = scene.views.iter().map(|view| view.path.clone()).collect();
    let mut cameras: BTreeMap<&str, Arc<Camera>> = BTreeMap::new();
    let (mut frames, mut unposed) = (Vec::new(), Vec::new());
    for (view, name) in scene.views.iter().zip(names::settled(&written, photographs)?) {
        let fault = |why| Error::malformed(&file, format!("view {}: {why}", shown(&view.path)));
        let Some(pose) = view.pose_id.as_deref().and_then(|id| poses.get(id)) else {
            unposed.push(name);
            continue;
        };
        let pose = view.within_rig(&scene.rigs, pose.pose().map_err(fault)?).map_err(fault)?;
        let id = view.intrinsic_id.as_deref().unwrap_or_default();
        let camera = match cameras.get(id) {
            Some(camera) => Arc::clone(camera),
            None => {
                let lens = scene.intrinsics.iter().find(|lens| lens.intrinsic_id == id);
                let lens =
                    lens.ok_or_else(|| fault(format!("its intrinsic {} is not among the intrinsics", shown(id))))?;
                let camera = Arc::new(lens.camera(version).map_err(fault)?);
                cameras.insert(id, Arc::clone(&camera));
                camera
            }
        };
        frames.push(Frame { name, camera, pose });
    }
    Ok(Posed { frames, unposed, ..Posed::default() })
}

impl View {
    /// The view's pose, where the pose that the file gives it is that of its rig.
    fn within_rig(&self, rigs: &[Rig], pose: Pose) -> Result<Pose, String> {
        let independent = self.is_pose_independant.as_deref().is_some_and(|text| text == "true" || text == "1");
        let Some(id) = self.rig_id.as_deref().filter(|_| !independent) else { return Ok(pose) };
        let at = self.sub_pose_id.map_or(0, |number| usize::cut(number.0));
        let rig = rigs.iter().find(|rig| rig.rig_id == id);
        let within = rig.and_then(|rig| rig.sub_poses.get(at));
        let within =
            within.ok_or_else(|| format!("its place {at} in rig {} is not among the rigs", shown(id)))?.pose.pose()?;
        let centre = pose.centre() + pose.to_world(within.centre());
        posed::at_centre(DMat3::from_quat(within.rotation * pose.rotation), centre)
    }
}
