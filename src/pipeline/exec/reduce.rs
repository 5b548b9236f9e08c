//! The reduce side: segments become materials, shard after shard, and the shards one table.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{Run, segments};
use crate::base::{Error, Result};
use crate::codec::npy;
use crate::disk::Manifest;
use crate::flow::{Flow, Reservation};
use crate::model::Estimator;
use crate::pipeline::plan::QUEUE;
use crate::pipeline::report::Shards as ShardCounts;
use crate::pipeline::scene::Loaded;
use crate::pipeline::{Pipeline, resume, shards};
use crate::scene::evidence::Evidence;
use crate::shard::format::SHARD;
use crate::stages::gather::{Group, open_blocks};
use crate::stages::infer::Infer;
use crate::stages::merge::{self, EVIDENCE, MATERIALS, Materials};
use crate::stages::shards::{Keep, Merged, Shard, UNIT};

impl Run<'_> {
    /// The reduce side: infers the shards that the manifest lacks, and gives the materials of all triangles, read back if
    /// they are there already, with the memory that they are held in.
    pub(super) fn reduce(
        &mut self,
        loaded: &Loaded,
        groups: &[Group],
        estimator: &dyn Estimator,
        manifest: &mut Manifest,
    ) -> Result<(Materials, Reservation)> {
        let files = groups.iter().filter_map(|g| manifest.files(&g.unit()));
        let blocks: Vec<_> = files.map(|files| open_blocks(&*self.store, files)).collect::<Result<_>>()?;
        let count = (loaded.mesh.len() as u32).div_ceil(SHARD);
        let all = shards::shards(&blocks, count, shards::made(self.pipeline, estimator.key()));
        let tables = format!("{}{}", merge::UNIT, shards::tables(self.pipeline, loaded.mesh_key, &all));
        let wanted: BTreeSet<String> = all.iter().map(Shard::unit).collect();
        resume::forget_others(manifest, UNIT, |unit| wanted.contains(unit))?;
        resume::forget_others(manifest, merge::UNIT, |unit| unit == tables)?;

        let to_do: Vec<Shard> = all.iter().filter(|s| manifest.files(&s.unit()).is_none()).cloned().collect();
        let (total, inferred) = (all.len() as u64, to_do.len() as u64);
        self.report.shards = ShardCounts { total, inferred, resumed: total - inferred };
        if !to_do.is_empty() {
            self.infer(&to_do, groups, estimator, manifest)?;
        }
        let held = self.budget.reserve("materials", Materials::BYTES_PER_TRIANGLE * loaded.mesh.len() as u64)?;
        if let Some(files) = manifest.files(&tables) {
            files.iter().try_for_each(|file| file.verify(&*self.store).map(drop))?;
            return Ok((read_materials(self.pipeline)?, held));
        }
        let materials = self.phase("merge", vec![], |run| {
            let materials = Materials::merge(&*run.store, &all, &loaded.mesh, run.pipeline.merge.fill)?;
            manifest.commit([(tables, materials.write(&*run.store)?)])?;
            Ok(materials)
        })?;
        Ok((materials, held))
    }

    fn infer(
        &mut self,
        shards: &[Shard],
        groups: &[Group],
        estimator: &dyn Estimator,
        manifest: &mut Manifest,
    ) -> Result<()> {
        let segments = segments(&*self.store, manifest, groups)?;
        let (min_bins, batch) = (self.pipeline.merge.min_bins as usize, self.pipeline.infer.batch as usize);
        let flow = Flow::source(self.stop, "shards", Merged { segments: &segments, shards })
            .map("infer", Infer { estimator, min_bins, batch }, self.threads, QUEUE)
            .fold("keep", Keep::new(shards, Arc::clone(&self.store), manifest), QUEUE);
        self.phase("infer", flow.meters(), |_| flow.run())
    }
}

/// Reads the tables of a finished run.
pub fn read_materials(pipeline: &Pipeline) -> Result<Materials> {
    let work = &pipeline.run.work;
    let rows = npy::read_rows(&work.join(MATERIALS))?;
    let evidence = npy::read_rows(&work.join(EVIDENCE))?.into_iter().map(Evidence::from_array).collect::<Vec<_>>();
    if rows.len() != evidence.len() {
        let found =
            format!("{} rows, and {MATERIALS} has {}: they belong to different runs", evidence.len(), rows.len());
        return Err(Error::malformed(work.join(EVIDENCE), found));
    }
    Ok(Materials { rows, evidence })
}
