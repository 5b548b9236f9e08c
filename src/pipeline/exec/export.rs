//! The exports, and what is made from a finished run.

use std::path::PathBuf;
use std::sync::Arc;

use super::{Run, open};
use crate::base::{Error, Result};
use crate::disk::{DirStore, Lock, Manifest, Recipe, Store};
use crate::flow::StopSignal;
use crate::pipeline::scene::Loaded;
use crate::pipeline::{Pipeline, Progress, resume};
use crate::scene::Mesh;
use crate::stages::export::{EXPORT, Format};
use crate::stages::merge::{Materials, TABLES};

impl Run<'_> {
    /// Writes the exports that the manifest lacks, each a unit.
    pub(super) fn export(
        &mut self,
        tables: &Recipe,
        mesh: &Mesh,
        materials: &Materials,
        manifest: &mut Manifest,
    ) -> Result<()> {
        let config = &self.pipeline.export;
        let all: Vec<(Format, Recipe)> = config.formats.iter().map(|&f| (f, config.recipe(f, tables))).collect();
        resume::forget_others(manifest, EXPORT, all.iter().map(|(_, recipe)| recipe))?;
        self.report.outputs = all.iter().map(|(format, _)| self.store.path(&format.file())).collect();
        let to_do: Vec<_> = all.into_iter().filter(|(_, recipe)| manifest.files(&recipe.unit()).is_none()).collect();
        if to_do.is_empty() {
            return Ok(());
        }
        self.phase("export", vec![], |run| {
            to_do.into_iter().try_for_each(|(format, recipe)| {
                let file = run.pipeline.export.write(format, mesh, materials, &*run.store)?;
                manifest.commit([(recipe, vec![file])])
            })
        })
    }
}

/// The scene, the materials and the recipe of the tables of a finished run.
///
/// # Errors
/// No finished materials, or those of another mesh; anything that cannot be read.
pub fn finished(pipeline: &Pipeline) -> Result<(Loaded, Materials, Recipe)> {
    let again = |why: &str| Error::invalid(format!("{why}: `gonio run {}` makes them", pipeline.file.display()));
    let store = DirStore::new(&pipeline.run.work);
    let manifest = Manifest::read(Arc::new(store.clone()))?;
    let tables = manifest.of_kind(TABLES).map(|(_, unit)| unit.recipe.clone()).next();
    let tables = tables.ok_or_else(|| again(&format!("{} has no materials yet", pipeline.run.work.display())))?;
    let materials = Materials::open(&store)?;
    let loaded = Loaded::read(pipeline)?;
    if tables.part("scene.mesh") != Some(&loaded.mesh_key.to_string()) || loaded.mesh.len() != materials.rows.len() {
        let mesh = pipeline.scene.mesh.display();
        return Err(again(&format!("the materials in {} are not those of {mesh}", pipeline.run.work.display())));
    }
    Ok((loaded, materials, tables))
}

/// Writes the exports of a finished run that are not there as they are configured now, and gives the paths of all.
///
/// # Errors
/// No finished materials; anything that cannot be read or written.
pub fn export(pipeline: &Pipeline) -> Result<Vec<PathBuf>> {
    let (loaded, materials, tables) = finished(pipeline)?;
    let _lock = Lock::acquire(&pipeline.run.work)?;
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&pipeline.run.work));
    let progress = Progress::new();
    let mut manifest = open(&store, &progress)?;
    let mut run = Run::new(store, pipeline, &StopSignal::new(), &progress);
    run.export(&tables, &loaded.mesh, &materials, &mut manifest)?;
    Ok(run.report.outputs)
}
