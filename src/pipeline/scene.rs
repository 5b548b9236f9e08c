//! The inputs of a run, read and prepared for casting. What is made of the mesh is kept in the run's store (`cache`), and
//! mapped from there by every command that finds it.

use std::sync::Arc;

use super::{Pipeline, PosesFormat};
use crate::base::ids::FrameId;
use crate::base::key::{Key, KeyBuilder};
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::cache::{self, Cached};
use crate::codec::{colmap, mesh};
use crate::disk::{DirStore, Manifest, Recipe, Store};
use crate::scene::Mesh;
use crate::scene::adjacency::Adjacency;
use crate::scene::frame::Frame;
use crate::stages::decode::Decode;
use crate::synth::city;
use crate::trace::Bvh;

/// A scene, in memory or mapped from its cache.
pub struct Loaded {
    /// The mesh.
    pub mesh: Mesh,
    /// The key of its file.
    pub mesh_key: Key,
    /// The posed photographs, sorted by name.
    pub frames: Vec<Frame>,
    /// What is mapped beside the mesh, if it is.
    cached: Option<Prepared>,
}

/// What a mesh is cast with.
struct Prepared {
    bvh: Bvh,
    adjacency: Adjacency,
    degenerate: u64,
}

/// The kind of the cache's unit.
pub const SCENE: &str = "scene";

/// The folder of the cache in a run's store.
pub const SCENES: &str = "scene/";

/// What the cache of a mesh is made of.
pub fn recipe(mesh: Key) -> Recipe {
    Recipe::new(SCENE).with("scene.mesh", mesh).with("format", cache::VERSION)
}

/// The cache's file.
fn file(mesh: Key) -> String {
    format!("{SCENES}{}.cache", recipe(mesh).unit())
}

/// The cache of a mesh, if the run has made one.
fn cached(store: &dyn Store, manifest: &Manifest, mesh: Key) -> Result<Option<Cached>> {
    let there = manifest.files(&recipe(mesh).unit()).is_some();
    there.then(|| cache::open(store, &file(mesh))).transpose()
}

/// Whether a mesh of so many bytes fits under the limit beside what the process holds already.
fn within(limit: Bytes, base: u64, mesh: u64) -> Result<()> {
    let needs = base.saturating_add(mesh);
    if needs <= limit.0 {
        return Ok(());
    }
    let hint = if base > mesh { "choose a smaller [infer] model" } else { "take a mesh of fewer triangles" };
    let [missing, base, mesh] = [needs - limit.0, base, mesh].map(Bytes);
    Err(Error::invalid(format!(
        "[run] memory = \"{limit}\" is {missing} too small: the mesh takes {mesh}, beside {base} for the process and its \
         model; give it more, or {hint}"
    )))
}

impl Loaded {
    /// Reads mesh and poses; the mesh from the run's cache if there is a good one.
    pub fn read(pipeline: &Pipeline) -> Result<Loaded> {
        Loaded::read_within(pipeline, &|_| Ok(()))
    }

    fn read_within(pipeline: &Pipeline, may: &dyn Fn(u64) -> Result<()>) -> Result<Loaded> {
        let mesh = Key::of_file(&pipeline.scene.mesh)?;
        let store = DirStore::new(&pipeline.run.work);
        // The cache is a copy: what is wrong with it is told by the next run, which makes it again.
        let cached = Manifest::read(Arc::new(store.clone())).and_then(|manifest| cached(&store, &manifest, mesh));
        Loaded::with(pipeline, mesh, cached.ok().flatten(), may)
    }

    /// The same for a run that holds `base` bytes already, which has a damaged cache made again.
    ///
    /// # Errors
    /// A mesh that is in no cache and does not fit under the limit: it is not read then.
    pub fn open(pipeline: &Pipeline, store: &dyn Store, manifest: &Manifest, base: u64) -> Result<Loaded> {
        let mesh = Key::of_file(&pipeline.scene.mesh)?;
        let cached = cached(store, manifest, mesh)?;
        Loaded::with(pipeline, mesh, cached, &|bytes| within(pipeline.run.memory, base, bytes))
    }

    fn with(
        pipeline: &Pipeline,
        mesh_key: Key,
        cached: Option<Cached>,
        may: &dyn Fn(u64) -> Result<()>,
    ) -> Result<Loaded> {
        let scene = &pipeline.scene;
        let (mesh, cached) = match cached {
            Some(Cached { mesh, bvh, adjacency, degenerate }) => (mesh, Some(Prepared { bvh, adjacency, degenerate })),
            None => (mesh::read_mesh(&scene.mesh, may)?, None),
        };
        let frames = match scene.poses.format {
            PosesFormat::Colmap => colmap::read_model(&scene.poses.path)?,
        };
        if frames.is_empty() {
            return Err(Error::malformed(&scene.poses.path, "it poses no image: at least one is needed"));
        }
        Ok(Loaded { mesh, mesh_key, frames, cached })
    }

    /// Whether mesh, hierarchy and neighbours are mapped.
    pub fn is_mapped(&self) -> bool {
        self.cached.is_some()
    }

    /// Bytes of memory that making the cache takes beside the mesh.
    pub fn building(&self) -> u64 {
        cache::building(self.mesh.len() as u64, self.mesh.positions.len() as u64)
    }

    /// Makes the cache as a unit of the run, and maps all of it in place of what is held.
    pub fn cache(&mut self, store: &dyn Store, manifest: &mut Manifest, interrupted: &dyn Fn() -> bool) -> Result<()> {
        let file = cache::write(&self.mesh, store, &file(self.mesh_key), interrupted)?;
        manifest.commit([(recipe(self.mesh_key), vec![file])])?;
        let Cached { mesh, bvh, adjacency, degenerate } = cache::open(store, &self::file(self.mesh_key))?;
        (self.mesh, self.cached) = (mesh, Some(Prepared { bvh, adjacency, degenerate }));
        Ok(())
    }

    /// The scene that a run will load, though it may not have been made yet.
    pub fn expected(pipeline: &Pipeline) -> Result<Loaded> {
        Loaded::expected_within(pipeline, &|_| Ok(()))
    }

    /// The same for a process that holds `base` bytes already.
    ///
    /// # Errors
    /// The same mesh that a run refuses.
    pub fn planned(pipeline: &Pipeline, base: u64) -> Result<Loaded> {
        Loaded::expected_within(pipeline, &|bytes| within(pipeline.run.memory, base, bytes))
    }

    fn expected_within(pipeline: &Pipeline, may: &dyn Fn(u64) -> Result<()>) -> Result<Loaded> {
        match &pipeline.synth {
            Some(synth) if !pipeline.is_made() => {
                // Its vertices come on top.
                may(u64::from(synth.city.triangles) * size_of::<[u32; 3]>() as u64)?;
                let mesh = city::build(&synth.city)?.mesh;
                Ok(Loaded {
                    mesh,
                    mesh_key: KeyBuilder::new("no file").finish(),
                    frames: city::frames(&synth.city),
                    cached: None,
                })
            }
            _ => Loaded::read_within(pipeline, may),
        }
    }

    /// What reads the frames. `replay` is the command that shows what one of them sees, but for its name.
    pub fn decode<'a>(&'a self, pipeline: &'a Pipeline, replay: &'a str) -> Decode<'a> {
        Decode {
            frames: &self.frames,
            images: &pipeline.scene.images,
            masks: pipeline.scene.masks.as_deref(),
            downscale: pipeline.decode.downscale,
            curve: pipeline.decode.curve(),
            replay,
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

    /// Bytes that the mesh takes, wherever they are.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.mesh.positions[..]) + size_of_val(&self.mesh.triangles[..])) as u64
    }

    /// The hierarchy: mapped, or built.
    pub fn bvh(&self) -> Bvh {
        self.cached.as_ref().map_or_else(|| Bvh::build(&self.mesh), |c| c.bvh.clone())
    }

    /// Which triangles touch: mapped, or worked out.
    pub fn adjacency(&self) -> Adjacency {
        self.cached.as_ref().map_or_else(|| Adjacency::of(&self.mesh), |c| c.adjacency.clone())
    }

    /// Triangles without area.
    pub fn degenerate(&self) -> u64 {
        self.cached.as_ref().map_or_else(|| self.mesh.degenerate() as u64, |c| c.degenerate)
    }
}
