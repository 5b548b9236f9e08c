//! The reduce side: segments become materials, shard after shard.

use super::{EVIDENCE, MATERIALS, Run, segments};
use crate::base::{Error, Result};
use crate::codec::npy;
use crate::disk::{FileEntry, Manifest};
use crate::flow::Flow;
use crate::model::Estimator;
use crate::pipeline::Pipeline;
use crate::pipeline::plan::QUEUE;
use crate::pipeline::scene::Loaded;
use crate::scene::Material;
use crate::scene::evidence::Evidence;
use crate::shard::format::SHARD;
use crate::stages::gather::Group;
use crate::stages::infer::{Infer, Shards};
use crate::stages::merge::{Materials, Merge};

impl Run<'_> {
    /// The reduce side: the materials of all triangles, read back if they are there already.
    pub(super) fn reduce(
        &mut self,
        loaded: &Loaded,
        groups: &[Group],
        estimator: &dyn Estimator,
        unit: &str,
        manifest: &mut Manifest,
    ) -> Result<Materials> {
        if let Some(files) = manifest.files(unit) {
            files.iter().try_for_each(|file| file.verify(&*self.store).map(drop))?;
            return read_materials(self.pipeline);
        }
        let segments = segments(&*self.store, manifest, groups)?;
        let count = (loaded.mesh.len() as u32).div_ceil(SHARD);
        let pipeline = self.pipeline;
        let held = self.budget.reserve("materials", Merge::BYTES_PER_TRIANGLE * loaded.mesh.len() as u64)?;
        let infer =
            Infer { estimator, min_bins: pipeline.merge.min_bins as usize, batch: pipeline.infer.batch as usize };
        let flow = Flow::source(self.stop, "shards", Shards { segments: &segments, count })
            .map("infer", infer, self.threads, QUEUE)
            .fold("merge", Merge::new(&loaded.mesh, pipeline.merge.fill), QUEUE);
        let materials = self.phase("infer", flow.meters(), |_| flow.run())?;
        let evidence: Vec<_> = materials.evidence.iter().map(|e| e.to_array()).collect();
        let files = [
            self.write_table(MATERIALS, Material::LEN, materials.rows.as_flattened())?,
            self.write_table(EVIDENCE, Evidence::LEN, evidence.as_flattened())?,
        ];
        manifest.commit([(unit.to_owned(), files.to_vec())])?;
        drop(held);
        Ok(materials)
    }

    fn write_table(&self, name: &str, columns: usize, values: &[f32]) -> Result<FileEntry> {
        let draft = self.store.create(name)?;
        let path = draft.path().to_owned();
        let shape = [values.len() / columns, columns];
        npy::write_f32(draft, &shape, values).map_err(Error::io("write", path))?.commit()
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
