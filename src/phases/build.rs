//! Build: the scene cache, made of the mesh once and mapped from then on.

use super::context::Context;
use super::facts::Facts;
use super::known::Known;
use super::phase::Phase;
use super::scene::cache_recipe;
use super::takes::{BYTES_PER_SECOND, Takes};
use super::units::{Extent, Unit, Units};
use crate::base::{PhaseName, Result};
use crate::cache;
use crate::disk::{Ledger, Store};
use crate::pipeline::Pipeline;
use crate::trace::Bvh;

/// The phase; its one unit is the scene cache.
pub(super) struct Build;

/// The folder of the scene cache in a run's store.
const FOLDER: &str = "scene/";

/// The bytes of a vertex in memory, and of a triangle.
const VERTEX: u64 = 12;

/// The bytes that the neighbours of a triangle take.
pub(super) const NEIGHBOURS: u64 = 16;

impl Phase for Build {
    fn name(&self) -> PhaseName {
        PhaseName::Build
    }

    fn units(&self, known: &Known<'_>, _: &dyn Store, _: &Ledger) -> Result<Units> {
        let recipe = cache_recipe(known.surveyed()?.scene.mesh_key);
        Ok(Units { noun: "scene caches", all: vec![Unit::new(recipe)], extent: Extent::Exact })
    }

    fn takes(&self, _: &Pipeline, facts: &Facts) -> Option<Takes> {
        let hierarchy = Bvh::BYTES_PER_TRIANGLE * facts.triangles;
        let building = cache::building(facts.triangles, (facts.mesh / VERTEX).saturating_sub(facts.triangles));
        (!facts.mapped).then(|| Takes {
            held: facts.mesh + building,
            held_for: "the mesh and the hierarchy over it",
            disk: facts.mesh + hierarchy + NEIGHBOURS * facts.triangles,
            units: 1,
            seconds: Some(hierarchy as f64 / BYTES_PER_SECOND),
            ..Takes::default()
        })
    }

    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()> {
        let stop = run.stop.clone();
        let scene = &run.known.surveyed()?.scene;
        let held = scene.mesh.held() + scene.building();
        let _held = run.budget.reserve("scene", held)?;
        for unit in to_do {
            let name = format!("{FOLDER}{}.{}.cache", unit.name, run.store.attempt());
            let file = cache::write(&run.known.surveyed()?.scene.mesh, &*run.store, &name, &|| stop.draining())?;
            run.commit(&unit.recipe, vec![file])?;
        }
        let (store, ledger) = (run.store.clone(), run.ledger.clone());
        run.known.surveyed_mut()?.scene.map(&*store, &ledger)
    }
}
