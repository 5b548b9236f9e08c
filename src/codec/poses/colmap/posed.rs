//! What both encodings say becomes cameras and frames.

use std::collections::BTreeMap;
use std::sync::Arc;

use glam::{DQuat, DVec3};

use super::models::PANORAMA;
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// The cameras of a model; `None` for a panorama.
#[derive(Debug, Default)]
pub(super) struct Cameras(BTreeMap<u32, Option<Arc<Camera>>>);

impl Cameras {
    /// Adds a camera.
    ///
    /// # Errors
    /// In words: an id that another camera has.
    pub(super) fn add(&mut self, id: u32, camera: Option<Camera>) -> Result<(), String> {
        match self.0.insert(id, camera.map(Arc::new)) {
            Some(_) => Err(format!("another camera has the id {id}")),
            None => Ok(()),
        }
    }

    /// The camera, where there is one.
    ///
    /// # Errors
    /// In words: none, several, or a panorama.
    pub(super) fn only(self) -> Result<Camera, String> {
        match (self.0.len(), self.0.into_values().next()) {
            (1, Some(Some(camera))) => Ok(Arc::unwrap_or_clone(camera)),
            (1, _) => Err(format!("its camera is of the model {PANORAMA}, which has no lens")),
            (count, _) => Err(format!("it has {count} cameras; one is needed")),
        }
    }
}

/// An image as the files have it.
#[derive(Debug)]
pub(super) struct Image {
    /// The path of the image below the image folder.
    pub name: String,
    /// The world-to-camera rotation: w, x, y, z.
    pub quaternion: [f64; 4],
    /// The world-to-camera translation.
    pub translation: [f64; 3],
    /// The id of the camera.
    pub camera: u32,
}

impl Image {
    /// The frame of the image.
    ///
    /// # Errors
    /// In words: a pose that is none, a camera that is not there or that is a panorama.
    pub(super) fn frame(self, cameras: &Cameras) -> Result<Frame, String> {
        let Image { name, quaternion, translation, camera } = self;
        let [w, x, y, z] = quaternion;
        let rotation = DQuat::from_xyzw(x, y, z, w);
        let length = rotation.length();
        if !(length.is_finite() && length > 1e-6) {
            return Err(format!("the quaternion of its rotation is {quaternion:?}; its length must not be 0"));
        }
        let translation = DVec3::from(translation);
        if !translation.is_finite() {
            return Err(format!("its translation is {translation}; every component must be finite"));
        }
        let Some(camera) = cameras.0.get(&camera) else {
            return Err(format!("its camera {camera} is not among the cameras"));
        };
        let Some(camera) = camera else {
            let instead = "export perspective views of it, or take its images out of the model";
            return Err(format!("its camera is of the model {PANORAMA}, which has no lens: {instead}"));
        };
        Ok(Frame { name, camera: Arc::clone(camera), pose: Pose { rotation: rotation.normalize(), translation } })
    }
}
