//! The map side: frames become segments, group after group.

use std::sync::Arc;

use super::Run;
use crate::base::{Error, Result};
use crate::disk::{Content, Manifest, Store};
use crate::flow::Flow;
use crate::pipeline::plan::QUEUE;
use crate::pipeline::report::{Frames as FrameCounts, Item};
use crate::pipeline::resume;
use crate::pipeline::scene::Loaded;
use crate::pipeline::share::CastShare;
use crate::shard::Segment;
use crate::stages::cast::Cast;
use crate::stages::frames::Frames;
use crate::stages::gather::{Gather, Group, Record, SEGMENT, read_record};

impl Run<'_> {
    /// The map side: casts the frames of the groups that the manifest lacks.
    pub(super) fn map(&mut self, loaded: &Loaded, groups: &[Group], manifest: &mut Manifest) -> Result<()> {
        let to_do = resume::to_do(manifest, groups);
        let frames: u64 = to_do.iter().map(|g| g.frames.len() as u64).sum();
        let total = loaded.frames.len() as u64;
        self.report.frames = FrameCounts { total, cast: frames, resumed: total - frames, skipped: 0 };
        if to_do.is_empty() {
            return self.count(groups, &to_do, manifest);
        }
        let bvh = loaded.bvh();
        let pipeline = self.pipeline;
        let replay = format!("gonio buffers {} --out frame.exr", pipeline.file.display());
        let decode = loaded.decode(pipeline, &replay);
        let share = self.plan.cast.share(self.budget.left()).map_err(|missing| self.budget.missing("cast", missing))?;
        let CastShare { workers, part, .. } = share;
        let held = self.budget.reserve("cast", share.casting + share.compressing)?;
        let rows = self.budget.reserve("gather", share.gather)?;
        let tile = pipeline.cast.tile;
        let downscale = pipeline.decode.downscale;
        let cast = Cast { frames: &loaded.frames, mesh: &loaded.mesh, bvh: &bvh, tile, downscale, part };
        let gather = Gather::new(&to_do, Arc::clone(&self.store), manifest, rows);
        let budget = self.budget.clone();
        let (decoding, memory) = (decode.clone(), budget.left());
        let frames = Frames { groups: &to_do, decode: decoding, budget: &budget, memory };
        let flow = Flow::source(&self.stop, "frames", frames)
            .map("decode", decode, workers, QUEUE)
            .map("cast", cast, workers, QUEUE)
            .fold("gather", gather, QUEUE);
        self.phase("cast", flow.meters(), |_| flow.run())?;
        drop(held);
        self.count(groups, &to_do, manifest)
    }

    /// Adds up what the groups' records say.
    fn count(&mut self, groups: &[Group], cast: &[Group], manifest: &Manifest) -> Result<()> {
        for group in groups {
            let files = manifest.files(&group.recipe.unit()).unwrap_or_default();
            let record: Record = read_record(&*self.store, files)?;
            if cast.contains(group) {
                self.report.rays += record.rays;
            }
            self.report.observations += record.observations;
            self.report.records += record.records;
            self.report.frames.skipped += record.skipped.len() as u64;
            let segments = files.iter().filter(|f| f.name.ends_with(SEGMENT));
            self.report.segment_bytes += segments.map(|f| f.bytes).sum::<u64>();
            let items = record.skipped.into_iter().map(|s| Item { item: s.frame, why: s.why, replay: s.replay });
            self.report.skipped.extend(items);
        }
        self.report.skipped.sort();
        if self.report.observations == 0 {
            return Err(Error::invalid(
                "no pixel of any frame saw the mesh from the front: mesh and poses are most likely in different \
                 coordinates, or the mesh's faces are turned inside out",
            ));
        }
        Ok(())
    }
}

/// Opens the segments of these groups.
pub fn segments(store: &dyn Store, manifest: &Manifest, groups: &[Group]) -> Result<Vec<Segment<Content>>> {
    let files = groups.iter().filter_map(|g| manifest.files(&g.recipe.unit())).flatten();
    files
        .filter(|file| file.name.ends_with(SEGMENT))
        .map(|file| Segment::open(store.open(&file.name)?, &store.path(&file.name)))
        .collect()
}
