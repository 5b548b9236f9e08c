//! What the coordinates of a scene are: which way is up, and where on the earth they lie. What the pipeline file does not say is
//! found in the poses and beside the inputs.

use std::path::Path;

use super::scene::{Scene, USUAL, UpFrom};
use crate::base::patience::Patience;
use crate::codec::poses::{self, PhotographFolder};
use crate::codec::{georeference, meshes};
use crate::scene::frame::Frame;
use crate::scene::georeference::Georeference;
use crate::scene::up::Upright;

impl Scene {
    /// Finds which way is up and where on the earth the scene lies, as far as the file does not say it. A city that the pipeline
    /// makes has its own way up.
    pub(super) fn find_coordinates(&mut self, makes_city: bool) {
        if makes_city {
            self.up_from = UpFrom::Given;
        }
        let seeks_up = self.up_from != UpFrom::Given;
        if makes_city || !seeks_up && self.crs.is_some() && self.offset.is_some() {
            return;
        }
        let (patience, photographs) = (Patience::default(), PhotographFolder::new(&self.images));
        let posed = patience.with(|| poses::look(self.poses.format, &self.poses.path, &photographs)).ok();
        let by_poses = posed.as_ref().and_then(|posed| posed.georeference);
        if let Some(told) = told(by_poses, &self.poses.path, self.mesh.first()) {
            self.crs = self.crs.or(told.crs);
            self.offset = self.offset.or(Some(told.offset));
        }
        if seeks_up {
            let ground = || patience.with(|| meshes::sample(&self.mesh)).ok();
            let upright = |frames: &[Frame]| {
                Upright::in_system(self.georeference(), frames).or_else(|| Upright::of(frames, ground))
            };
            let found = posed.and_then(|posed| upright(&posed.frames));
            self.up = found.map_or(USUAL, |found| found.up);
            self.up_from = UpFrom::Scene(found);
        }
    }
}

/// Where on the earth a scene lies: what its poses say, or else files beside poses or mesh.
pub(crate) fn told(posed: Option<Georeference>, poses: &Path, mesh: &Path) -> Option<Georeference> {
    posed.or_else(|| georeference::beside(poses)).or_else(|| georeference::beside(mesh))
}
