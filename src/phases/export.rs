//! Export: the tables become files that viewers and renderers load, a format a unit.

use std::path::PathBuf;

use glam::DVec3;

use super::cause::FORMAT;
use super::context::Context;
use super::facts::Facts;
use super::known::Known;
use super::merge::tables_recipe;
use super::phase::Phase;
use super::takes::{BYTES_PER_SECOND, Takes};
use super::units::{Extent, Unit, Units};
use crate::base::{PhaseName, Result};
use crate::config::Effect;
use crate::disk::Recipe;
use crate::disk::{Ledger, Store};
use crate::pipeline::Pipeline;
use crate::scene::Mesh;
use crate::stages::export::{EXPORTERS, Exporter, Surface};
use crate::stages::merge::Materials;

/// The phase; a unit is a format.
pub(super) struct Export;

/// The bytes of memory that an export holds: rows of pictures, and what is written and not yet on its way.
const HELD: u64 = 2 << 20;

/// All that an exporter's files depend on, given the recipe of the tables.
fn recipe(pipeline: &Pipeline, exporter: &Exporter, tables: &Recipe) -> Recipe {
    let recipe = Recipe::new(PhaseName::Export, exporter.name)
        .with(PhaseName::Merge.as_str(), tables.unit())
        .with(FORMAT, exporter.version)
        .with_all(pipeline.ingredients(Effect::Place));
    // Only what turns its axes depends on which way is up.
    if exporter.turns_axes { recipe.with_all(pipeline.ingredients(Effect::Axes)) } else { recipe }
}

impl Phase for Export {
    fn name(&self) -> PhaseName {
        PhaseName::Export
    }

    fn outputs(&self) -> Vec<&'static str> {
        EXPORTERS.iter().flat_map(|exporter| exporter.files).copied().collect()
    }

    fn units(&self, known: &Known<'_>, store: &dyn Store, ledger: &Ledger) -> Result<Units> {
        let (tables, whole) = tables_recipe(known, store, ledger)?;
        let made = whole && ledger.is_done(&tables.unit());
        let all = known.pipeline.export.formats.iter().map(|e| Unit::new(recipe(known.pipeline, e, &tables))).collect();
        Ok(Units { noun: "exports", all, extent: if made { Extent::Exact } else { Extent::Renewed } })
    }

    fn takes(&self, pipeline: &Pipeline, facts: &Facts) -> Option<Takes> {
        let formats = &pipeline.export.formats;
        let disk: u64 = formats.iter().map(|e| e.bytes_per_triangle * facts.triangles).sum();
        let units = formats.len() as u64;
        (units > 0).then(|| Takes {
            held: HELD,
            held_for: "what is kept of every triangle",
            mapped: facts.mesh + super::infer::ROW_BYTES * facts.triangles,
            disk,
            units,
            seconds: Some(disk as f64 / BYTES_PER_SECOND),
            ..Takes::default()
        })
    }

    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()> {
        let recipes = to_do.iter().map(|unit| &unit.recipe);
        write(run.pipeline, &*run.store, &run.ledger, &run.known.surveyed()?.scene.mesh, recipes)
    }

    fn tell(&self, run: &mut Context<'_>, _: &Units, _: &[Unit]) -> Result<()> {
        run.report.outputs = outputs(run.pipeline, &*run.store);
        Ok(())
    }
}

/// Writes the files of these recipes, each a unit.
fn write<'a>(
    pipeline: &Pipeline,
    store: &dyn Store,
    ledger: &Ledger,
    mesh: &Mesh,
    recipes: impl Iterator<Item = &'a Recipe>,
) -> Result<()> {
    let materials = Materials::open(store)?;
    let scene = &pipeline.scene;
    let surface = Surface { mesh, materials: &materials, up: DVec3::from(scene.up), place: scene.georeference() };
    for recipe in recipes {
        for exporter in pipeline.export.formats.iter().filter(|exporter| exporter.name == recipe.what()) {
            ledger.commit(recipe, (exporter.write)(&surface, store)?)?;
        }
    }
    Ok(())
}

/// The paths of the files that the pipeline exports.
fn outputs(pipeline: &Pipeline, store: &dyn Store) -> Vec<PathBuf> {
    pipeline.export.formats.iter().flat_map(|exporter| exporter.files).map(|file| store.path(file)).collect()
}

/// Writes the exports of finished tables that are not there as they are configured now, and gives the paths of all.
///
/// # Errors
/// Tables that cannot be read, or files that cannot be written.
pub(crate) fn export_tables(
    pipeline: &Pipeline,
    store: &dyn Store,
    ledger: &Ledger,
    mesh: &Mesh,
    tables: &Recipe,
) -> Result<Vec<PathBuf>> {
    let recipes: Vec<Recipe> =
        pipeline.export.formats.iter().map(|exporter| recipe(pipeline, exporter, tables)).collect();
    let wanted: Vec<_> = recipes.iter().map(Recipe::unit).collect();
    ledger.forget(ledger.of_phase(PhaseName::Export).into_iter().filter(|unit| !wanted.contains(unit)))?;
    write(pipeline, store, ledger, mesh, recipes.iter().filter(|recipe| !ledger.is_done(&recipe.unit())))?;
    Ok(outputs(pipeline, store))
}
