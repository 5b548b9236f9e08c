//! What every look at a finished run begins with.

use std::path::Path;
use std::sync::Arc;

use crate::base::{Array, Error, PhaseName, Result};
use crate::disk::Recipe;
use crate::disk::{DirStore, Ledger, Store};
use crate::flow::pool;
use crate::phases::light::{FoundLight, FrozenLight};
use crate::phases::{LoadedScene, Meshes};
use crate::pipeline::Pipeline;
use crate::stages::light::Mode;
use crate::stages::merge::Materials;
use crate::stages::scene_light::SunAndSky;
use crate::trace::Bvh;

/// A finished run.
pub(super) struct Finished {
    /// The scene that it was run on.
    pub scene: LoadedScene,
    /// The materials that came of it.
    pub materials: Materials,
    /// The recipe of the tables that hold them.
    pub tables: Recipe,
    /// The light of the photographs, where it is known or was found.
    pub light: Option<SunAndSky>,
    /// What was found of exposures and light.
    pub frozen: FrozenLight,
}

/// The scene of a pipeline, with the run's folder as it is.
pub(super) fn looked_at(pipeline: &Pipeline) -> Result<(Arc<dyn Store>, Ledger, LoadedScene)> {
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&pipeline.run.work));
    let (ledger, _) = pool::share(pipeline.run.threads(), || Ledger::read(Arc::clone(&store)))??;
    let scene = LoadedScene::read(pipeline, &*store, &ledger, Meshes::Any)?;
    Ok((store, ledger, scene))
}

impl Finished {
    /// Opens a finished run.
    ///
    /// # Errors
    /// No finished materials, or those of another mesh; anything that cannot be read.
    pub(super) fn open(pipeline: &Pipeline) -> Result<Self> {
        let again = |why: &str| Error::invalid(format!("{why}: `gonio run {}` makes them", pipeline.file.display()));
        let work = pipeline.run.work.display();
        let (store, ledger, scene) = looked_at(pipeline)?;
        let tables = ledger.of_phase(PhaseName::Merge).first().map(|unit| ledger.recipe(unit)).transpose()?;
        let tables = tables.ok_or_else(|| again(&format!("{work} has no materials yet")))?;
        let materials = Materials::open(&*store)?;
        let same = tables.ingredient("scene.mesh") == Some(&scene.mesh_key.to_string());
        if !same || scene.mesh.len() != materials.rows.len() {
            let mesh = &pipeline.scene.mesh;
            return Err(again(&format!("the materials in {work} are not those of {mesh}")));
        }
        let frozen = FrozenLight::read(&store, pipeline, scene.mesh_key)?;
        let light = match pipeline.light.mode {
            Mode::Estimate | Mode::Ephemeris => frozen.state().light.as_ref().and_then(FoundLight::sun_and_sky),
            Mode::Known | Mode::Unknown => pipeline.light.known(),
        };
        Ok(Finished { scene, materials, tables, light, frozen })
    }
}

/// A finished run over its scene, ready to be rendered.
#[derive(Clone, Copy)]
pub(super) struct Over<'a> {
    /// The pipeline.
    pub pipeline: &'a Pipeline,
    /// The run.
    pub finished: &'a Finished,
    /// The hierarchy over the mesh.
    pub bvh: &'a Bvh,
    /// The share of the sky that each triangle sees.
    pub visibility: &'a Array<f32>,
}

/// Checks that the folder of an output file exists.
///
/// # Errors
/// The folder does not exist.
pub(super) fn writable(pipeline: &Pipeline, out: &Path) -> Result<()> {
    pipeline.may_write(out)?;
    match out.parent().filter(|folder| !folder.as_os_str().is_empty()) {
        Some(folder) if !folder.is_dir() => {
            Err(Error::invalid(format!("{}: there is no folder {}: make it first", out.display(), folder.display())))
        }
        _ => Ok(()),
    }
}
