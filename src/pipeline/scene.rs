//! The inputs of a run, read and prepared for casting.

use super::{Pipeline, PosesFormat};
use crate::base::Error;
use crate::base::Result;
use crate::base::ids::FrameId;
use crate::base::key::{Key, KeyBuilder};
use crate::codec::{colmap, mesh};
use crate::scene::Mesh;
use crate::scene::frame::Frame;
use crate::synth::city;
use crate::trace::Bvh;

/// A scene in memory.
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// The key of its file.
    pub mesh_key: Key,
    /// The posed photographs, sorted by name.
    pub frames: Vec<Frame>,
}

impl Loaded {
    /// Reads mesh and poses.
    pub fn read(pipeline: &Pipeline) -> Result<Loaded> {
        let scene = &pipeline.scene;
        let mesh = mesh::read_mesh(&scene.mesh)?;
        let mesh_key = Key::of_file(&scene.mesh)?;
        let frames = match scene.poses.format {
            PosesFormat::Colmap => colmap::read_model(&scene.poses.path)?,
        };
        if frames.is_empty() {
            return Err(Error::malformed(&scene.poses.path, "it poses no image: at least one is needed"));
        }
        Ok(Loaded { mesh, mesh_key, frames })
    }

    /// The scene that a run will load, though it may not have been made yet.
    pub fn expected(pipeline: &Pipeline) -> Result<Loaded> {
        match &pipeline.synth {
            Some(synth) if !pipeline.scene.mesh.exists() => {
                let mesh = city::build(&synth.city)?.mesh;
                Ok(Loaded { mesh, mesh_key: KeyBuilder::new("no file").finish(), frames: city::frames(&synth.city) })
            }
            _ => Loaded::read(pipeline),
        }
    }

    /// The frame of this name.
    pub fn frame(&self, name: &str) -> Result<(FrameId, &Frame)> {
        let found = self.frames.binary_search_by(|f| f.name.as_str().cmp(name)).ok();
        found.map(|i| (i as FrameId, &self.frames[i])).ok_or_else(|| {
            let near = self.frames.iter().map(|f| (strsim::jaro_winkler(&f.name, name), &f.name));
            let near = near.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, n)| n.as_str()).unwrap_or_default();
            Error::invalid(format!("no frame is named {name:?}; did you mean {near:?}?"))
        })
    }

    /// Bytes of memory that the mesh holds.
    pub fn bytes(&self) -> u64 {
        (size_of_val(self.mesh.positions.as_slice()) + size_of_val(self.mesh.triangles.as_slice())) as u64
    }

    /// Builds the hierarchy.
    pub fn bvh(&self) -> Bvh {
        Bvh::build(&self.mesh)
    }
}
