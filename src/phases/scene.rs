//! The inputs of a run, read and prepared for casting. What is made of the mesh lies in the scene cache, and every command that
//! finds one maps it.

use std::sync::Arc;

use super::cause::FORMAT;
use super::photographs::find_photographs;
use super::rounded::round_up;
use crate::base::ids::FrameId;
use crate::base::key::{Key, KeyBuilder};
use crate::base::patience::Patience;
use crate::base::shown::quoted;
use crate::base::units::Bytes;
use crate::base::{Error, PhaseName, Result};
use crate::cache::{self, Cached};
use crate::codec::meshes::MeshFiles;
use crate::codec::poses::{self, PhotographFolder};
use crate::disk::Recipe;
use crate::disk::{Ledger, Store};
use crate::pipeline::{Pipeline, UpFrom};
use crate::scene::Mesh;
use crate::scene::adjacency::Adjacency;
use crate::scene::frame::Frame;
use crate::stages::decode::Decode;
use crate::synth::city;
use crate::trace::Bvh;

/// A scene, in memory or mapped from its cache.
pub struct LoadedScene {
    /// The mesh.
    pub mesh: Mesh,
    /// The key of the mesh file.
    pub mesh_key: Key,
    /// The posed frames, sorted by name.
    pub frames: Vec<Frame>,
    /// The posed frames that are left out, to judge by.
    pub held_out: Vec<Frame>,
    /// What was assumed of the names of photographs.
    pub assumed: Option<String>,
    /// What is mapped beside the mesh, if it is.
    cached: Option<Prepared>,
}

/// What a mesh is cast with.
struct Prepared {
    bvh: Bvh,
    adjacency: Adjacency,
    degenerate: u64,
}

/// Which meshes may be read into memory.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Meshes {
    /// Any mesh.
    Any,
    /// A mesh that fits under `[run] memory` beside what the process holds already.
    Within {
        /// The bytes that the process holds.
        held: u64,
    },
}

impl Meshes {
    fn check(self, limit: Bytes, mesh: u64) -> Result<()> {
        let Meshes::Within { held } = self else { return Ok(()) };
        let needs = held.saturating_add(mesh);
        if needs <= limit.0 {
            return Ok(());
        }
        let hint = if held > mesh { "choose a smaller [infer] model" } else { "take a mesh of fewer triangles" };
        let [missing, held, mesh] = [needs - limit.0, held, mesh].map(Bytes);
        Err(Error::invalid(format!(
            "[run] memory = \"{limit}\" is {missing} too small: the mesh takes {mesh}, beside {held} for the process and its \
             model; raise the limit, or {hint}"
        )))
    }
}

/// All that the scene cache of a mesh depends on.
pub(super) fn cache_recipe(mesh: Key) -> Recipe {
    Recipe::new(PhaseName::Build, "").with("scene.mesh", mesh).with(FORMAT, cache::VERSION)
}

/// The scene cache of a mesh, if the run has made one.
fn cached(store: &dyn Store, ledger: &Ledger, mesh: Key) -> Result<Option<Cached>> {
    let files = ledger.files(&cache_recipe(mesh).unit());
    files.and_then(|files| Some(files.first()?.name.clone())).map(|name| cache::open(store, &name)).transpose()
}

/// The frames that are used, and those that are left out.
fn divided(pipeline: &Pipeline, frames: Vec<Frame>) -> (Vec<Frame>, Vec<Frame>) {
    let Some(every) = pipeline.run.holdout else { return (frames, Vec::new()) };
    let (held_out, used): (Vec<_>, Vec<_>) = frames.into_iter().enumerate().partition(|(at, _)| every.has(*at));
    let frames = |numbered: Vec<(usize, Frame)>| numbered.into_iter().map(|(_, frame)| frame).collect();
    (frames(used), frames(held_out))
}

impl LoadedScene {
    /// Reads mesh and poses for a run; the mesh from the scene cache if there is one.
    ///
    /// # Errors
    /// Inputs that cannot be read; a mesh that is in no cache and does not fit, before it is read; a damaged cache.
    pub(super) fn of_run(pipeline: &Pipeline, store: &dyn Store, ledger: &Ledger, meshes: Meshes) -> Result<Self> {
        LoadedScene::with(pipeline, &|mesh| cached(store, ledger, mesh), meshes)
    }

    /// Reads mesh and poses to look at them. A damaged cache is passed over: the next run tells of it and makes it over.
    ///
    /// # Errors
    /// Inputs that cannot be read, a mesh that does not fit.
    pub fn read(pipeline: &Pipeline, store: &dyn Store, ledger: &Ledger, meshes: Meshes) -> Result<Self> {
        LoadedScene::with(pipeline, &|mesh| Ok(cached(store, ledger, mesh).ok().flatten()), meshes)
    }

    /// The scene that a run will load, though its city may not have been made yet.
    ///
    /// # Errors
    /// Those of [`LoadedScene::read`].
    pub(super) fn foreseen(pipeline: &Pipeline, store: &dyn Store, ledger: &Ledger, meshes: Meshes) -> Result<Self> {
        match &pipeline.synth {
            Some(synth) if !pipeline.is_made() => {
                // The vertices come on top.
                meshes.check(pipeline.run.memory, u64::from(synth.city.triangles) * size_of::<[u32; 3]>() as u64)?;
                let (frames, held_out) = divided(pipeline, city::frames(&synth.city));
                Ok(LoadedScene {
                    mesh: city::mesh(&synth.city)?,
                    mesh_key: KeyBuilder::new("no file").finish(),
                    frames,
                    held_out,
                    assumed: None,
                    cached: None,
                })
            }
            _ => LoadedScene::read(pipeline, store, ledger, meshes),
        }
    }

    fn with(pipeline: &Pipeline, cached: &dyn Fn(Key) -> Result<Option<Cached>>, fitting: Meshes) -> Result<Self> {
        let (scene, patience) = (&pipeline.scene, Patience::default());
        let may = |bytes| fitting.check(pipeline.run.memory, bytes);
        let (mesh_key, mesh, cached) = patience.with(|| {
            // IMPORTANT: the mesh is hashed and read from the same open files, so that its key is that of what is cast.
            let mut files = MeshFiles::open(&scene.mesh)?;
            let key = files.key()?;
            Ok(match cached(key)? {
                Some(Cached { mesh, bvh, adjacency, degenerate }) => {
                    (key, mesh, Some(Prepared { bvh, adjacency, degenerate }))
                }
                None => (key, files.read(&may)?, None),
            })
        })?;
        let photographs = PhotographFolder::new(&scene.images);
        let mut frames = patience.with(|| poses::read(scene.poses.format, &scene.poses.path, &photographs))?;
        if scene.up_from == UpFrom::Scene(None) {
            let again = "which could not be read a moment ago, and tell the way up: try again";
            return Err(Error::io("read", &scene.poses.path)(std::io::Error::other(again)));
        }
        let assumed = find_photographs(&mut frames, &scene.images, &photographs);
        round_up(&mut frames, &scene.images, pipeline.decode.downscale);
        let (frames, held_out) = divided(pipeline, frames);
        Ok(LoadedScene { mesh, mesh_key, frames, held_out, assumed, cached })
    }

    /// Maps mesh, hierarchy and neighbours from the scene cache in place of what is held.
    pub(super) fn map(&mut self, store: &dyn Store, ledger: &Ledger) -> Result<()> {
        if let Some(Cached { mesh, bvh, adjacency, degenerate }) = cached(store, ledger, self.mesh_key)? {
            (self.mesh, self.cached) = (mesh, Some(Prepared { bvh, adjacency, degenerate }));
        }
        Ok(())
    }

    /// Whether mesh, hierarchy and neighbours are mapped.
    pub fn is_mapped(&self) -> bool {
        self.cached.is_some()
    }

    /// The bytes of memory that making the scene cache takes beside the mesh.
    pub(super) fn building(&self) -> u64 {
        cache::building(self.mesh.len() as u64, self.mesh.positions.len() as u64)
    }

    /// The stage that reads the frames.
    pub(crate) fn decode<'a>(&'a self, pipeline: &'a Pipeline) -> Decode<'a> {
        Decode {
            frames: &self.frames,
            images: &pipeline.scene.images,
            masks: pipeline.scene.masks.as_deref(),
            downscale: pipeline.decode.downscale,
            curve: pipeline.decode.curve(),
            replay: format!("gonio buffers {} --out frame.exr", quoted(&pipeline.file.to_string_lossy())),
            patience: Arc::default(),
        }
    }

    /// The frame of this name, and its id.
    ///
    /// # Errors
    /// No frame has the name; the nearest name is told.
    pub fn frame(&self, name: &str) -> Result<(FrameId, &Frame)> {
        let found = self.frames.binary_search_by(|f| f.name.as_str().cmp(name)).ok();
        found.map(|i| (FrameId::at(i), &self.frames[i])).ok_or_else(|| {
            let near = self.frames.iter().map(|f| (strsim::jaro_winkler(&f.name, name), &f.name));
            let near = near.max_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, n)| n.as_str()).unwrap_or_default();
            Error::invalid(format!("no frame is named {name:?}; did you mean {near:?}?"))
        })
    }

    /// The bytes of the mesh, in memory or mapped.
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

    /// The number of triangles without area.
    pub fn degenerate(&self) -> u64 {
        self.cached.as_ref().map_or_else(|| self.mesh.degenerate() as u64, |c| c.degenerate)
    }
}
