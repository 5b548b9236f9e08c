//! Merge: the rows of all shards become one table of materials and one of evidence, and what was hardly seen is filled.

use super::build::NEIGHBOURS;
use super::cause::FORMAT;
use super::context::Context;
use super::facts::Facts;
use super::infer::{ROW_BYTES, shards_done};
use super::known::Known;
use super::phase::Phase;
use super::report::TriangleCounts;
use super::takes::{BYTES_PER_SECOND, Takes};
use super::units::{Extent, Unit, Units};
use crate::base::key::KeyBuilder;
use crate::base::{PhaseName, Result};
use crate::config::Effect;
use crate::disk::Recipe;
use crate::disk::{Ledger, Store};
use crate::pipeline::Pipeline;
use crate::scene::Material;
use crate::scene::evidence::Filled;
use crate::stages::merge::{self, EVIDENCE, MATERIALS, Materials};

/// The phase; its one unit is both tables.
pub(super) struct Merge;

/// The bytes of a triangle's material in scratch.
const SCRATCH: u64 = (Material::LEN * size_of::<f32>()) as u64;

impl Phase for Merge {
    fn name(&self) -> PhaseName {
        PhaseName::Merge
    }

    fn outputs(&self) -> Vec<&'static str> {
        vec![MATERIALS, EVIDENCE]
    }

    fn units(&self, known: &Known<'_>, store: &dyn Store, ledger: &Ledger) -> Result<Units> {
        let (recipe, whole) = tables_recipe(known, store, ledger)?;
        let extent = if whole { Extent::Exact } else { Extent::Renewed };
        Ok(Units { noun: "tables", all: vec![Unit::new(recipe)], extent })
    }

    fn takes(&self, pipeline: &Pipeline, facts: &Facts) -> Option<Takes> {
        let scratch = SCRATCH * facts.triangles;
        let tables = ROW_BYTES * facts.triangles;
        Some(Takes {
            held: merge::bytes(facts.triangles),
            held_for: "what is kept of every triangle",
            // The scratch of the materials is mapped, and so are the neighbours; a shard's rows are few.
            mapped: NEIGHBOURS * facts.triangles + scratch,
            // Where triangles are filled, the materials come to lie in scratch first.
            disk: tables + if pipeline.merge.fill { scratch } else { 0 },
            units: 1,
            seconds: Some(2.0 * tables as f64 / BYTES_PER_SECOND),
            ..Takes::default()
        })
    }

    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()> {
        let scene = &run.known.surveyed()?.scene;
        let triangles = scene.mesh.len();
        let _held = run.budget.reserve("merge", merge::bytes(triangles as u64))?;
        let shards = shards_done(&run.known, &*run.store, &run.ledger)?;
        let adjacency = run.pipeline.merge.fill.then(|| scene.adjacency());
        for unit in to_do {
            let files = merge::merge(&*run.store, &shards, triangles, adjacency.as_ref())?;
            run.commit(&unit.recipe, files)?;
        }
        Ok(())
    }

    fn tell(&self, run: &mut Context<'_>, _: &Units, _: &[Unit]) -> Result<()> {
        let scene = &run.known.surveyed()?.scene;
        let (total, degenerate) = (scene.mesh.len() as u64, scene.degenerate());
        let counts = Materials::open(&*run.store)?.counts();
        let of = |filled: Filled| counts[filled as usize];
        run.report.triangles = TriangleCounts {
            total,
            degenerate,
            seen: of(Filled::Observed),
            filled: of(Filled::Neighbours) + of(Filled::SceneMean),
            empty: of(Filled::Nothing),
        };
        Ok(())
    }
}

/// The recipe of the tables that the shards, as they are now, become; and whether all shards are done, so that it is the last
/// word.
///
/// # Errors
/// A file in the run's folder cannot be read.
pub(super) fn tables_recipe(known: &Known<'_>, store: &dyn Store, ledger: &Ledger) -> Result<(Recipe, bool)> {
    let shards = super::infer::Infer.units(known, store, ledger)?;
    let start = KeyBuilder::new("gonio shards 1");
    let all = shards.all.iter().fold(start, |key, unit| key.field(unit.name.to_string().as_bytes())).finish();
    let recipe = Recipe::new(PhaseName::Merge, "")
        .with("scene.mesh", known.surveyed()?.scene.mesh_key)
        .with(PhaseName::Infer.as_str(), all)
        .with_all(known.pipeline.ingredients(Effect::Merge))
        .with(FORMAT, merge::VERSION);
    let whole = shards.extent == Extent::Exact && shards.all.iter().all(|unit| ledger.is_done(&unit.name));
    Ok((recipe, whole))
}
