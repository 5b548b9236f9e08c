//! The reduce side: segments become materials, shard after shard, and the shards one table.

use std::sync::Arc;

use super::{Run, segments};
use crate::base::Result;
use crate::disk::{Manifest, Recipe};
use crate::flow::Flow;
use crate::model::Estimator;
use crate::pipeline::plan::QUEUE;
use crate::pipeline::report::Shards as ShardCounts;
use crate::pipeline::scene::Loaded;
use crate::pipeline::share::InferInputs;
use crate::pipeline::{resume, shards};
use crate::shard::{merge_least, merge_need};
use crate::stages::gather::Group;
use crate::stages::infer::Infer;
use crate::stages::light::SceneLight;
use crate::stages::merge::{self, Materials, TABLES};
use crate::stages::shards::{Keep, Merged, SHARD, Shard};

impl Run<'_> {
    /// The reduce side: infers the shards that the manifest lacks, and gives the materials of all triangles, mapped, and the
    /// recipe of their tables.
    pub(super) fn reduce(
        &mut self,
        loaded: &Loaded,
        groups: &[Group],
        estimator: &dyn Estimator,
        manifest: &mut Manifest,
    ) -> Result<(Materials, Recipe)> {
        let triangles = loaded.mesh.len();
        let all = shards::of_groups(self.pipeline, estimator, &*self.store, manifest, groups, loaded)?;
        let tables = shards::tables(self.pipeline, loaded.mesh_key, &all);
        resume::forget_others(manifest, SHARD, all.iter().map(|shard| &shard.recipe))?;
        resume::forget_others(manifest, TABLES, [&tables])?;

        let to_do: Vec<Shard> = all.iter().filter(|s| manifest.files(&s.recipe.unit()).is_none()).cloned().collect();
        let (total, inferred) = (all.len() as u64, to_do.len() as u64);
        self.report.shards = ShardCounts { total, inferred, resumed: total - inferred };
        if !to_do.is_empty() {
            self.infer(loaded, &to_do, groups, estimator, manifest)?;
        }
        if let Some(files) = manifest.files(&tables.unit()) {
            files.iter().try_for_each(|file| file.verify(&*self.store).map(drop))?;
        } else {
            let _held = self.budget.reserve("merge", merge::bytes(triangles as u64))?;
            self.phase("merge", vec![], |run| {
                let adjacency = run.pipeline.merge.fill.then(|| loaded.adjacency());
                let files = merge::merge(&*run.store, &all, triangles, adjacency.as_ref())?;
                manifest.commit([(tables.clone(), files)])
            })?;
        }
        Ok((Materials::open(&*self.store)?, tables))
    }

    fn infer(
        &mut self,
        loaded: &Loaded,
        shards: &[Shard],
        groups: &[Group],
        estimator: &dyn Estimator,
        manifest: &mut Manifest,
    ) -> Result<()> {
        let segments = segments(&*self.store, manifest, groups)?;
        let most = |need: fn(&[_], u32) -> u64| shards.iter().map(|s| need(&segments, s.number)).max().unwrap_or(0);
        let inputs = InferInputs { shard: most(merge_need), least: most(merge_least), ..self.plan.infer };
        let share = inputs.share(self.budget.left()).map_err(|missing| self.budget.missing("infer", missing))?;
        let held = self.budget.reserve("infer", share.inferring)?;
        let (min_bins, batch) = (self.pipeline.merge.min_bins as usize, self.pipeline.infer.batch as usize);
        let bvh = estimator.contract().light.wanted().then(|| loaded.bvh());
        let (config, up) = (&self.pipeline.light, self.pipeline.export.up);
        let light = bvh.as_ref().map(|bvh| SceneLight::new(config, &loaded.mesh, bvh, up));
        let budget = self.budget.clone();
        let merged = Merged { segments: &segments, shards, budget: &budget, room: share.room() };
        let flow = Flow::source(&self.stop, "shards", merged)
            .map("infer", Infer { estimator, light, min_bins, batch }, share.workers, QUEUE)
            .fold("keep", Keep::new(shards, Arc::clone(&self.store), manifest), QUEUE);
        self.phase("infer", flow.meters(), |_| flow.run())?;
        drop(held);
        Ok(())
    }
}
