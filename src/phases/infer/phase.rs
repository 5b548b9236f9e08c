//! The infer phase: a unit is a shard.

use std::sync::Arc;

use super::shards::recipes_of;
use super::share::InferNeeds;
use crate::base::ids::ShardId;
use crate::base::{Error, PhaseName, Result};
use crate::disk::Recipe;
use crate::disk::{Ledger, Store};
use crate::flow::Flow;
use crate::phases::cast::opened_segments;
use crate::phases::context::Context;
use crate::phases::facts::Facts;
use crate::phases::known::Known;
use crate::phases::phase::Phase;
use crate::phases::report::ShardCounts;
use crate::phases::takes::{QUEUE, Takes};
use crate::phases::units::{Extent, Unit, Units};
use crate::pipeline::Pipeline;
use crate::scene::Material;
use crate::scene::evidence::Evidence;
use crate::shard::{collect_least, collect_need};
use crate::stages::infer;
use crate::stages::scene_light::SceneLights;
use crate::stages::shards::{Collected, Keep, RowsFile, Shard};

/// The phase; a unit is a shard.
pub(crate) struct Infer;

/// The bytes of a triangle's material and evidence.
pub(in crate::phases) const ROW_BYTES: u64 = ((Material::LEN + Evidence::LEN) * size_of::<f32>()) as u64;

/// The shard that a recipe is of.
fn shard(recipe: &Recipe) -> Result<Shard> {
    let number = recipe.what().parse().map_err(|_| Error::invalid(format!("{:?} is no shard", recipe.what())))?;
    Ok(Shard { id: ShardId(number), recipe: recipe.clone() })
}

/// The shards of the scene whose rows are there, in order.
///
/// # Errors
/// A file in the run's folder cannot be read.
pub(in crate::phases) fn shards_done(known: &Known<'_>, store: &dyn Store, ledger: &Ledger) -> Result<Vec<RowsFile>> {
    let mut shards = Vec::new();
    for recipe in recipes_of(known, store, ledger)? {
        let files = ledger.files(&recipe.unit());
        if let Some(file) = files.as_deref().and_then(|files| files.first()) {
            shards.push(RowsFile { shard: shard(&recipe)?.id, name: file.name.clone() });
        }
    }
    Ok(shards)
}

impl Phase for Infer {
    fn name(&self) -> PhaseName {
        PhaseName::Infer
    }

    fn units(&self, known: &Known<'_>, store: &dyn Store, ledger: &Ledger) -> Result<Units> {
        let all = recipes_of(known, store, ledger)?.into_iter().map(Unit::new).collect();
        let groups = &known.surveyed()?.groups;
        let cast = groups.all().iter().chain(groups.looks()).all(|group| ledger.is_done(&group.recipe.unit()));
        Ok(Units { noun: "shards", all, extent: if cast { Extent::Exact } else { Extent::AtLeast } })
    }

    fn takes(&self, pipeline: &Pipeline, facts: &Facts) -> Option<Takes> {
        let needs = InferNeeds::of(facts);
        let memory = pipeline.run.memory.0.saturating_sub(facts.process);
        let (stages, staged, workers) = needs.stages(memory);
        let lighting = facts.trial.map_or(0.0, |trial| trial.seconds_per_light);
        let seconds = facts.triangles as f64 * (facts.seconds_per_map + lighting);
        Some(Takes {
            stages,
            held_for: "the mesh",
            staged,
            needed: needs.least(),
            disk: ROW_BYTES * facts.triangles,
            units: facts.triangles.div_ceil(u64::from(ShardId::TRIANGLES)),
            seconds: Some(seconds / workers.max(1) as f64),
            ..Takes::default()
        })
    }

    /// Shards that nothing was seen of have no rows, which is known once there are tables.
    fn unwritten(&self, takes: &Takes, ledger: &Ledger) -> u64 {
        if !ledger.of_phase(PhaseName::Merge).is_empty() {
            return 0;
        }
        let left = takes.units.saturating_sub(ledger.of_phase(PhaseName::Infer).len() as u64);
        takes.unwritten(left)
    }

    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()> {
        let pipeline = run.pipeline;
        let shards: Vec<Shard> = to_do.iter().map(|unit| shard(&unit.recipe)).collect::<Result<_>>()?;
        let surveyed = run.known.surveyed()?;
        let (estimator, scene) = (&*run.known.estimator, &surveyed.scene);
        let segments = opened_segments(&*run.store, &run.ledger, surveyed.groups.all())?;
        let most = |need: fn(&[_], ShardId) -> u64| shards.iter().map(|s| need(&segments, s.id)).max().unwrap_or(0);
        let expected = InferNeeds::of(&surveyed.facts);
        let needs = InferNeeds { shard: most(collect_need), least: most(collect_least), ..expected };
        let share = needs.share(run.budget.left()).map_err(|missing| run.budget.missing("infer", missing))?;
        let _held = run.budget.reserve("infer", share.inferring)?;
        let (min_bins, batch) = (pipeline.infer.min_bins, pipeline.infer.batch as usize);
        let lights = if estimator.contract().light.wanted() { run.known.lights() } else { Vec::new() };
        let bvh = (!lights.is_empty()).then(|| scene.bvh());
        let over = |bvh| SceneLights::new(&lights, &scene.mesh, bvh, pipeline.scene.up);
        let lights = bvh.as_ref().and_then(over);
        let (stop, budget, ledger) = (run.stop.clone(), run.budget.clone(), Arc::clone(&run.ledger));
        let collected = Collected { segments: &segments, shards: &shards, budget: &budget, each: share.each() };
        let commit = |recipe: &Recipe, files| ledger.commit(recipe, files).map(drop);
        let flow = Flow::source(&stop, "shards", collected)
            .map("infer", infer::Infer { estimator, lights, min_bins, batch }, share.workers, QUEUE)
            .fold("keep", Keep::new(&shards, Arc::clone(&run.store), &commit), QUEUE);
        run.progress.watch(flow.meters());
        flow.run()
    }

    fn tell(&self, run: &mut Context<'_>, units: &Units, done: &[Unit]) -> Result<()> {
        let (total, inferred) = (units.all.len() as u64, done.len() as u64);
        run.report.shards = ShardCounts { total, inferred, resumed: total - inferred };
        Ok(())
    }
}
