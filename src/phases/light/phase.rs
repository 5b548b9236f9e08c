//! The light phase: its one unit is what is known of exposures and light.

use std::sync::Arc;

use super::file::{DOME, LIGHT, write};
use super::frozen::{FrozenLight, VERSION};
use super::occasion::{Occasion, all_told};
use super::solve::Evidence;
use crate::base::key::{Key, KeyBuilder};
use crate::base::{PhaseName, Result};
use crate::config::Effect;
use crate::disk::{Damage, Ledger, Recipe, Rotten, Store};
use crate::flow::pool;
use crate::light::{Sighting, TRIANGLES};
use crate::phases::cause::FORMAT;
use crate::phases::context::Context;
use crate::phases::facts::Facts;
use crate::phases::known::Known;
use crate::phases::look::{Look, Seen};
use crate::phases::phase::Phase;
use crate::phases::takes::Takes;
use crate::phases::units::{Extent, Unit, Units};
use crate::pipeline::Pipeline;
use crate::stages::light::Mode;

/// The phase; its one unit is `light.json`.
pub(crate) struct Light;

/// The ingredient that stands for the number of entries of the frozen list: where there are fewer, its end was lost.
const ENTRIES: &str = PhaseName::Light.as_str();

/// The sightings that are used, at most. Where there are more, every so many-th is.
const MOST: u64 = 400_000;

/// The bytes that finding takes beside the sightings, and the seconds.
const FINDING: u64 = 24 << 20;
const SECONDS: f64 = 3.0;

/// The bytes on disk of what is found, for each frame and beside.
const EACH: u64 = 64;
const BESIDE: u64 = 1 << 18;

impl Phase for Light {
    fn name(&self) -> PhaseName {
        PhaseName::Light
    }

    fn outputs(&self) -> Vec<&'static str> {
        vec![LIGHT, DOME]
    }

    fn units(&self, known: &Known<'_>, store: &dyn Store, ledger: &Ledger) -> Result<Units> {
        let looks = Look.units(known, store, ledger)?;
        if looks.extent == Extent::Absent {
            return Ok(Units::absent());
        }
        let whole = looks.all.iter().all(|unit| ledger.is_done(&unit.name));
        let recipe = recipe(known, &looks)?;
        let extent = if whole { Extent::Exact } else { Extent::Renewed };
        Ok(Units { noun: "lights", all: vec![Unit::new(recipe)], extent })
    }

    fn rotten(&self, store: &Arc<dyn Store>, ledger: &Ledger) -> Result<Vec<Rotten>> {
        let recipes = ledger.of_phase(PhaseName::Light).into_iter().map(|unit| ledger.recipe(&unit));
        let recipes = recipes.collect::<Result<Vec<Recipe>>>()?;
        let entries = recipes.iter().filter_map(|recipe| recipe.ingredient(ENTRIES)?.parse().ok()).max();
        let damage = FrozenLight::rotten(store, entries.unwrap_or(0))?;
        Ok(damage.into_iter().map(|Damage { page, why, .. }| Rotten { file: page, unit: None, why }).collect())
    }

    fn takes(&self, pipeline: &Pipeline, facts: &Facts) -> Option<Takes> {
        let rows = MOST.min(facts.frames * facts.triangles.min(TRIANGLES as u64));
        pipeline.is_looked_at().then(|| Takes {
            held: held(rows),
            held_for: "what the frames saw of the triangles that were looked at",
            mapped: facts.mesh,
            disk: EACH * facts.frames + BESIDE,
            units: 1,
            seconds: Some(SECONDS),
            ..Takes::default()
        })
    }

    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()> {
        let looks = Look.units(&run.known, &*run.store, &run.ledger)?;
        let sightings = key(&looks);
        let pipeline = run.pipeline;
        if run.known.surveyed()?.light.key(sightings).is_none() {
            let seen = Seen::read(&run.known, &*run.store, &run.ledger, MOST)?;
            let _held = run.budget.reserve("light", held(seen.rows.len() as u64))?;
            let surveyed = run.known.surveyed_mut()?;
            let (scene, sample) = (&surveyed.scene, surveyed.light.sample());
            let (rows, images) = (&seen.rows, &seen.images);
            let told = pool::share(pipeline.run.threads(), || all_told(pipeline, &scene.frames))?;
            if pipeline.light.mode == Mode::Ephemeris {
                Occasion::told(pipeline, &told)?;
            }
            let bvh = &scene.bvh();
            let evidence = Evidence { pipeline, scene, bvh, sample: &sample, sightings: rows, told: &told, images };
            let light = &mut surveyed.light;
            light.freeze(sightings, |known| pool::share(pipeline.run.threads(), || evidence.looked(known)))?;
        }
        let recipe = recipe(&run.known, &looks)?;
        let state = run.known.surveyed()?.light.state();
        for _ in to_do {
            let files = write(&*run.store, state, pipeline.scene.up)?;
            run.commit(&recipe, files)?;
        }
        Ok(())
    }

    fn tell(&self, run: &mut Context<'_>, _: &Units, _: &[Unit]) -> Result<()> {
        run.known.settle_estimator()?;
        run.report.backend = run.known.estimator.describe();
        let state = run.known.surveyed()?.light.state();
        if let Some(doubt) = state.light.as_ref().and_then(|light| light.doubt.as_ref()) {
            run.progress.note(format!("the sun is taken from [light] place and time, but {doubt}"));
        }
        run.report.light = Some(state.report());
        run.known.needs_light()
    }
}

/// The bytes that so many sightings take, as they are read and while gains and light are found.
fn held(rows: u64) -> u64 {
    4 * rows * size_of::<Sighting>() as u64 + FINDING
}

/// The key of all that the frames saw.
fn key(looks: &Units) -> Key {
    let start = KeyBuilder::new("gonio sightings 1");
    looks.all.iter().fold(start, |key, unit| key.field(unit.name.to_string().as_bytes())).finish()
}

/// The recipe of what is known of the light, which depends on what was known before.
fn recipe(known: &Known<'_>, looks: &Units) -> Result<Recipe> {
    let surveyed = known.surveyed()?;
    let sightings = key(looks);
    let start = KeyBuilder::new("gonio light 1").field(sightings.to_string().as_bytes());
    let frozen = surveyed.light.key(sightings).map_or_else(String::new, |key| key.to_string());
    Ok(Recipe::new(PhaseName::Light, "")
        .with("scene.mesh", surveyed.scene.mesh_key)
        .with(PhaseName::Look.as_str(), start.field(frozen.as_bytes()).finish())
        .with(ENTRIES, surveyed.light.entries())
        .with_all(known.pipeline.ingredients(Effect::Look))
        .with(FORMAT, VERSION))
}
