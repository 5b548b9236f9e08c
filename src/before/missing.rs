//! What is missing in a project's folder, and how people make it.

use glam::DVec3;

use super::cameras::database;
use super::found::Found;
use super::listing::named;
use super::photographs::{self, Fit, Photographs};
use super::usual::{IMAGES, MESH, formats};
use crate::base::shown::quoted;
use crate::codec::poses::{COLMAP, METASHAPE};
use crate::scene::seen::middle;

impl Found {
    /// What is missing, and how it is made, a few lines each.
    pub(crate) fn missing(&self) -> Vec<String> {
        let poses = self.cameras().is_none().then(|| self.poses());
        let photographs = self.cameras().and_then(|_| self.images());
        let mesh = if self.mesh().is_none() { Some(self.surface()) } else { self.unseen() };
        [poses, photographs, mesh].into_iter().flatten().collect()
    }

    fn poses(&self) -> String {
        let broken: String = self.broken.iter().map(|why| format!("\n  {why}")).collect();
        let how = match database(&self.listing) {
            Some(database) => {
                let database = quoted(&database);
                format!("\n  colmap mapper --database_path {database} --image_path {IMAGES} --output_path sparse")
            }
            None => format!("\n  {}", formats()),
        };
        format!("missing: where the cameras stood{broken}{how}")
    }

    fn images(&self) -> Option<String> {
        let first = self.cameras()?.frames.first()?;
        match self.photographs() {
            None => {
                let beside = photographs::beside(&self.root, &self.cameras()?.frames).map(|(folder, count)| {
                    let all = self.cameras().map_or(0, |cameras| cameras.frames.len());
                    format!(
                        "\n  {folder} has {count} of {all} of their names: if it is theirs, set images = \"{folder}\""
                    )
                });
                Some(format!(
                    "missing: the photographs\n  none of those that the poses name is here, as {}; put them into {IMAGES}, or \
                     link it{}",
                    first.name,
                    beside.unwrap_or_default()
                ))
            }
            Some(Photographs { fit: Fit::Not(why), folder, .. }) => {
                Some(format!("missing: photographs of the cameras' sizes\n  in {}, {why}", named(folder)))
            }
            Some(_) => None,
        }
    }

    /// Tells of a mesh that no camera sees.
    fn unseen(&self) -> Option<String> {
        let (mesh, cameras) = (self.surfaces.meshes.first()?, self.cameras()?);
        if mesh.seen.is_none_or(|seen| seen > 0.0) {
            return None;
        }
        let centres: Vec<DVec3> = cameras.frames.iter().map(|frame| frame.pose.centre()).collect();
        let (stand, lies) = (middle(&centres), middle(&mesh.points));
        let advice = if *cameras.format == METASHAPE {
            "export it once more: in geocentric coordinates (EPSG:4978) where the chunk is georeferenced, and without a shift"
        } else {
            "export mesh and poses once more, both in the same coordinates, without a shift"
        };
        Some(format!(
            "missing: a mesh in the coordinates of the poses\n  no camera sees {}: it lies about {lies}, and they stand about \
             {stand}\n  {advice}",
            mesh.file
        ))
    }

    fn surface(&self) -> String {
        let mut words = "missing: the mesh, in the coordinates of the poses".to_owned();
        for (file, why) in &self.surfaces.others {
            words.push_str(&format!("\n  {file} is none: {why}"));
        }
        let is_colmap = self.cameras().is_some_and(|cameras| *cameras.format == COLMAP);
        let cloud = self.listing.files.iter().find(|file| file.rsplit('/').next() == Some("fused.ply"));
        match (cloud, self.cameras(), self.photographs()) {
            (Some(cloud), ..) => {
                words.push_str(&format!(
                    "\n  colmap poisson_mesher --input_path {} --output_path {MESH}",
                    quoted(cloud)
                ));
            }
            (None, Some(cameras), Some(photographs)) if is_colmap => {
                let (images, poses) = (quoted(named(&photographs.folder)), quoted(named(&cameras.path)));
                words.push_str(&format!(
                    "\n  colmap image_undistorter --image_path {images} --input_path {poses} --output_path dense\
                     \n  colmap patch_match_stereo --workspace_path dense\
                     \n  colmap stereo_fusion --workspace_path dense --output_path dense/fused.ply\
                     \n  colmap poisson_mesher --input_path dense/fused.ply --output_path {MESH}"
                ));
            }
            _ => {
                words.push_str("\n  export it from the program that posed the cameras, as PLY or OBJ, beside the poses")
            }
        }
        words
    }
}
