//! The cast phase: a unit is a frame group.

use std::sync::Arc;

use super::causes::causes;
use super::commits::Commits;
use super::frozen::Frozen;
use super::groups::Group;
use super::share::{CastNeeds, CastShare};
use crate::base::convert::Cut;
use crate::base::{Error, PhaseName, Result};
use crate::disk::{Damage, Ledger, Recipe, Rotten, Store};
use crate::flow::{Flow, Skipped, pool};
use crate::phases::cause::Cause;
use crate::phases::context::Context;
use crate::phases::facts::{Facts, USUAL_BINS};
use crate::phases::known::Known;
use crate::phases::light::suns_of;
use crate::phases::phase::Phase;
use crate::phases::report::FrameCounts;
use crate::phases::takes::{QUEUE, Takes};
use crate::phases::units::{Extent, Unit, Units};
use crate::pipeline::Pipeline;
use crate::stages::cast::{self, Counts};
use crate::stages::frames::Frames;
use crate::stages::gather::{Gather, SEGMENT, read_tally};
use crate::stages::sunlit::Sunlit;
use crate::trace::Bvh;

/// The phase; a unit is a group of frames.
pub(crate) struct Cast;

/// The bytes on disk of a segment's record; measured were 9.3 to 10.
const RECORD_ON_DISK: u64 = 10;

impl Phase for Cast {
    fn name(&self) -> PhaseName {
        PhaseName::Cast
    }

    /// Groups are frozen before a unit of theirs is named, and by now gains are known.
    fn prepare(&self, run: &mut Context<'_>) -> Result<()> {
        let (pipeline, ledger) = (run.pipeline, Arc::clone(&run.ledger));
        let surveyed = run.known.surveyed_mut()?;
        // Where another process froze other groups, their photographs are looked at, many at once.
        pool::share(pipeline.run.threads(), || {
            let (scene, light) = (&surveyed.scene, &surveyed.light);
            if !pipeline.is_looked_at() {
                surveyed.groups.freeze(pipeline, &ledger, scene, light)?;
            }
            surveyed.groups.cast(pipeline, &ledger, scene, light)
        })?
    }

    fn units(&self, known: &Known<'_>, _: &dyn Store, ledger: &Ledger) -> Result<Units> {
        let surveyed = known.surveyed()?;
        let all = surveyed.groups.all().iter().map(Group::unit).collect();
        // Before exposures and light are found for the first time, all is to come.
        let waits = known.pipeline.is_looked_at() && surveyed.light.state().sightings.is_none();
        let looked = surveyed.groups.looks().iter().all(|group| ledger.is_done(&group.recipe.unit()));
        let extent = if waits && !looked { Extent::Renewed } else { Extent::Exact };
        Ok(Units { noun: "frames", all, extent })
    }

    fn rotten(&self, store: &Arc<dyn Store>, ledger: &Ledger) -> Result<Vec<Rotten>> {
        let damage = Frozen::read(store, ledger)?.damage().cloned();
        Ok(damage.into_iter().map(|Damage { page, why, .. }| Rotten { file: page, unit: None, why }).collect())
    }

    fn causes(&self, now: Option<&Recipe>, before: &[Recipe]) -> Vec<Cause> {
        causes(now, before)
    }

    fn takes(&self, pipeline: &Pipeline, facts: &Facts) -> Option<Takes> {
        let needs = CastNeeds::of(pipeline, facts);
        let memory = pipeline.run.memory.0.saturating_sub(facts.process);
        let (stages, staged, workers) = needs.stages(memory);
        let records = facts.triangles * USUAL_BINS as u64 * facts.groups.min(USUAL_BINS as u64);
        // Frames of a group that see a triangle from about the same side share its records, which makes them fewer.
        let seen = facts.trial.map_or(facts.pixels, |trial| u64::cut(facts.pixels as f64 * trial.records_per_pixel));
        Some(Takes {
            stages,
            held_for: "the mesh",
            staged,
            needed: needs.least(),
            mapped: facts.mesh + Bvh::BYTES_PER_TRIANGLE * facts.triangles,
            disk: records.min(seen) * RECORD_ON_DISK,
            units: facts.groups,
            seconds: facts.trial.map(|t| facts.pixels as f64 * t.seconds_per_pixel / workers.max(1) as f64),
            ..Takes::default()
        })
    }

    /// Where segments are there, those to come are taken to be like them.
    fn unwritten(&self, takes: &Takes, ledger: &Ledger) -> u64 {
        let done = ledger.of_phase(PhaseName::Cast);
        let files = done.iter().filter_map(|unit| ledger.files(unit));
        let bytes: u64 = files.map(|files| files.iter().map(|file| file.bytes).sum::<u64>()).sum();
        let left = takes.units.saturating_sub(done.len() as u64) as f64;
        let (bytes, units) = if done.is_empty() { (takes.disk, takes.units) } else { (bytes, done.len() as u64) };
        u64::cut(bytes as f64 * left / units.max(1) as f64)
    }

    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()> {
        let pipeline = run.pipeline;
        let groups = Group::of_units(run.known.surveyed()?.groups.all(), to_do);
        let (store, ledger, budget) = (Arc::clone(&run.store), Arc::clone(&run.ledger), run.budget.clone());
        let stop = run.stop.clone();
        let surveyed = run.known.surveyed()?;
        let needs = CastNeeds::of(pipeline, &surveyed.facts);
        let share = needs.share(budget.left()).map_err(|missing| budget.missing("cast", missing))?;
        let CastShare { workers, piece, .. } = share;
        let _held = budget.reserve("cast", share.casting + share.compressing)?;
        let rows = budget.reserve("gather", share.gather)?;
        let scene = &surveyed.scene;
        let bvh = scene.bvh();
        let decode = scene.decode(pipeline);
        let (tile, downscale) = (pipeline.cast.tile, pipeline.decode.downscale);
        let conditions = surveyed.groups.conditions();
        let find = |sun| pool::share(pipeline.run.threads(), || Sunlit::new(sun, &scene.mesh, &bvh));
        let suns = suns_of(pipeline, &surveyed.light).into_iter().map(|sun| sun.map(find).transpose());
        let suns = suns.collect::<Result<Vec<_>>>()?;
        let cast = cast::Cast {
            frames: &scene.frames,
            mesh: &scene.mesh,
            bvh: &bvh,
            tile,
            downscale,
            piece,
            conditions: &conditions,
            suns: &suns,
        };
        let commits = Commits::new(&ledger, &scene.frames);
        let commit = |group: &_, contents: &_, files| commits.commit(group, contents, files);
        let gather = Gather::new(&groups, store, rows, &commit);
        let frames = Frames { groups: &groups, decode: decode.clone(), budget: &budget, memory: budget.left() };
        let flow = Flow::source(&stop, "frames", frames)
            .map("decode", decode, workers, QUEUE)
            .map("cast", cast, workers, QUEUE)
            .fold("gather", gather, QUEUE);
        run.progress.watch(flow.meters());
        flow.run()?;
        let read = commits.recipes();
        run.known.surveyed_mut()?.groups.settle(&read);
        Ok(())
    }

    fn tell(&self, run: &mut Context<'_>, units: &Units, done: &[Unit]) -> Result<()> {
        let total = units.all.iter().map(|unit| unit.weight).sum();
        let cast = done.iter().map(|unit| unit.weight).sum();
        let mut frames = FrameCounts { total, cast, resumed: total - cast, skipped: 0 };
        let (report, mut counts) = (&mut run.report, Counts::default());
        // What could not be looked at is told of here, once.
        report.skipped.clear();
        for unit in &units.all {
            let files = run.ledger.files(&unit.name).unwrap_or_default();
            let tally = read_tally(&*run.store, &files)?;
            if done.contains(unit) {
                report.rays += tally.counts.rays;
            }
            report.observations += tally.counts.observations;
            counts += tally.counts;
            report.records += tally.records;
            let skipped = tally.skipped.len() as u64;
            frames.skipped += skipped;
            let counted = if done.contains(unit) { &mut frames.cast } else { &mut frames.resumed };
            *counted = counted.saturating_sub(skipped);
            report.segment_bytes += files.iter().filter(|f| f.name.ends_with(SEGMENT)).map(|f| f.bytes).sum::<u64>();
            report.skipped.extend(tally.skipped);
        }
        report.frames = frames;
        report.skipped.sort();
        if report.observations == 0 {
            return Err(Error::invalid(nothing_seen(total, &counts, &report.skipped)));
        }
        doubts(&counts).into_iter().for_each(|doubt| run.progress.note(doubt));
        Ok(())
    }
}

/// Why nothing was observed, as far as it can be told.
fn nothing_seen(frames: u64, counts: &Counts, skipped: &[Skipped]) -> String {
    if counts.rays == 0 {
        let first = skipped.first().map(|first| format!(": {}: {}", first.item, first.why)).unwrap_or_default();
        return format!("none of the {frames} photographs could be read{first}; `gonio check` looks at all of them");
    }
    if counts.unmasked == 0 {
        return "the masks ignore every pixel of every photograph that was read: what is 0 in a mask, or clear, is ignored; \
                are they inverted?"
            .to_owned();
    }
    let also = if counts.behind > 0 {
        "the mesh's faces are turned inside out: it was seen from behind alone"
    } else {
        "mesh and poses are most likely in different coordinates: no ray met the mesh"
    };
    format!("no pixel of any photograph saw the mesh from the front: {also}")
}

/// What makes the observations doubtful.
fn doubts(counts: &Counts) -> Vec<String> {
    let share = |part: u64, of: u64| part as f64 / of.max(1) as f64;
    let behind = share(counts.behind, counts.behind + counts.observations);
    let turned = (behind > 0.2).then(|| {
        format!(
            "{:.0}% of the pixels saw faces from behind, which count for nothing: some faces of the mesh are turned inside \
             out; a program such as MeshLab orients them alike",
            100.0 * behind
        )
    });
    let bright = (share(counts.bright, counts.observations) > 0.5).then(|| {
        "more than half of the pixels are brighter than 10, where a white surface in the sun should be about 1: scale the \
         photographs, as from 0 to 255 to 0 to 1"
            .to_owned()
    });
    turned.into_iter().chain(bright).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_went_wrong_gets_the_blame() {
        let skipped = [Skipped { item: "a.jpg".into(), why: "images/a.jpg: torn".into(), replay: String::new() }];
        let read = Counts { rays: 9, ..Counts::default() };
        for (counts, words) in [
            (Counts::default(), "none of the 3 photographs could be read: a.jpg: images/a.jpg: torn"),
            (read, "masks ignore every pixel"),
            (Counts { unmasked: 9, ..read }, "different coordinates"),
            (Counts { unmasked: 9, behind: 4, ..read }, "inside out"),
        ] {
            let said = nothing_seen(3, &counts, &skipped);
            assert!(said.contains(words) && (said.contains("coordinates") == words.contains("coordinates")), "{said}");
        }
        let seen = Counts { observations: 90, behind: 30, bright: 50, ..read };
        assert_eq!(doubts(&seen).len(), 2);
        assert!(doubts(&seen)[0].starts_with("25% of the pixels saw faces from behind"));
        assert_eq!(doubts(&Counts { behind: 20, bright: 4, ..seen }), [""; 0]);
    }
}
