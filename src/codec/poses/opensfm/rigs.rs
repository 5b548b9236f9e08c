//! Rigs: cameras that are mounted together. Where a shot has no pose of its own, it has that of its rig's instance, and then
//! that of the camera within the rig.

use std::collections::BTreeMap;

use glam::DVec3;
use serde::Deserialize;

use crate::base::shown::shown;
use crate::codec::poses::posed;
use crate::scene::pose::Pose;

/// A rotation, as an axis whose length is its angle, and a translation.
#[derive(Debug, Clone, Copy, Deserialize)]
pub(super) struct Turned {
    /// The axis.
    pub rotation: [f64; 3],
    /// The translation.
    pub translation: [f64; 3],
}

impl Turned {
    /// The pose.
    ///
    /// # Errors
    /// In words: a number that is not finite.
    pub(super) fn pose(self) -> Result<Pose, String> {
        posed::moved(posed::about(self.rotation.into())?, DVec3::from(self.translation))
    }
}

/// A rig where it stood once.
#[derive(Debug, Clone, Deserialize)]
pub(super) struct Instance {
    rotation: [f64; 3],
    translation: [f64; 3],
    /// The rig's camera of each shot.
    #[serde(default)]
    rig_camera_ids: BTreeMap<String, String>,
}

/// The poses that rigs give to their shots.
#[derive(Debug)]
pub(super) struct Rigs<'a> {
    of_shot: BTreeMap<&'a str, (&'a Instance, &'a str)>,
    cameras: &'a BTreeMap<String, Turned>,
}

impl<'a> Rigs<'a> {
    /// The rigs of a reconstruction.
    pub(super) fn of(instances: &'a BTreeMap<String, Instance>, cameras: &'a BTreeMap<String, Turned>) -> Self {
        let shots = instances.values().flat_map(|instance| {
            instance.rig_camera_ids.iter().map(move |(shot, camera)| (shot.as_str(), (instance, camera.as_str())))
        });
        Rigs { of_shot: shots.collect(), cameras }
    }

    /// The pose of a shot; `None` if no rig has it.
    ///
    /// # Errors
    /// In words: a camera that the rig has not, a number that is not finite.
    pub(super) fn pose(&self, shot: &str) -> Result<Option<Pose>, String> {
        let Some((instance, name)) = self.of_shot.get(shot) else { return Ok(None) };
        let camera = self.cameras.get(*name);
        let camera =
            camera.ok_or_else(|| format!("its rig camera {} is not among rig_cameras", shown(name)))?.pose()?;
        let rig = Turned { rotation: instance.rotation, translation: instance.translation }.pose()?;
        Ok(Some(Pose {
            rotation: (camera.rotation * rig.rotation).normalize(),
            translation: camera.rotation * rig.translation + camera.translation,
        }))
    }
}
