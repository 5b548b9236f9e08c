//! The look phase: a unit is a frame group.

use std::sync::Arc;

use crate::base::{PhaseName, Result};
use crate::disk::{Ledger, Recipe, Store};
use crate::flow::{Flow, pool};
use crate::light::{Sighting, TRIANGLES, sample};
use crate::phases::cast::{Commits, Group, causes};
use crate::phases::cause::Cause;
use crate::phases::context::Context;
use crate::phases::facts::Facts;
use crate::phases::known::Known;
use crate::phases::phase::Phase;
use crate::phases::takes::{QUEUE, STACK, StageTakes, Takes};
use crate::phases::units::{Extent, Unit, Units};
use crate::pipeline::Pipeline;
use crate::stages::frames::Frames;
use crate::stages::look::{self, Keep, read_skipped, usual_pixels};
use crate::trace::Bvh;

/// The phase; a unit is a group of frames.
pub(crate) struct Look;

/// What one thread takes to look at a triangle that a frame sees, seconds.
const SECONDS: f64 = 2e-5;

/// The bytes that a worker holds beside the frame: its stack, and what it saw.
const WORKER: u64 = 2 * STACK + 2 * TRIANGLES as u64 * size_of::<Sighting>() as u64;

impl Look {
    /// The triangles of the sample that a frame sees, as far as one can tell.
    const SEEN: u64 = TRIANGLES as u64 / 2;

    /// The workers that this memory is enough for, at least one.
    fn workers(pipeline: &Pipeline, frame: u64, memory: u64) -> usize {
        let fits = |workers: &usize| *workers as u64 * (frame + 3 * WORKER) <= memory;
        (1..=pipeline.run.threads()).rev().find(fits).unwrap_or(1)
    }
}

impl Phase for Look {
    fn name(&self) -> PhaseName {
        PhaseName::Look
    }

    /// The groups, and the triangles that are looked at, are frozen before a unit is named.
    fn prepare(&self, run: &mut Context<'_>) -> Result<()> {
        let (pipeline, ledger) = (run.pipeline, Arc::clone(&run.ledger));
        if !pipeline.is_looked_at() {
            return Ok(());
        }
        let surveyed = run.known.surveyed_mut()?;
        pool::share(pipeline.run.threads(), || {
            let scene = &surveyed.scene;
            surveyed.light.freeze_sample(|| {
                let sizes = usual_pixels(&scene.mesh, &scene.frames, pipeline.decode.downscale);
                sample(&scene.mesh, pipeline.scene.zenith(), &sizes, TRIANGLES)
            })?;
            surveyed.groups.freeze(pipeline, &ledger, scene, &surveyed.light)
        })?
    }

    fn units(&self, known: &Known<'_>, _: &dyn Store, _: &Ledger) -> Result<Units> {
        if !known.pipeline.is_looked_at() {
            return Ok(Units::absent());
        }
        let all = known.surveyed()?.groups.looks().iter().map(Group::unit).collect();
        Ok(Units { noun: "looks", all, extent: Extent::Exact })
    }

    fn causes(&self, now: Option<&Recipe>, before: &[Recipe]) -> Vec<Cause> {
        causes(now, before)
    }

    fn takes(&self, pipeline: &Pipeline, facts: &Facts) -> Option<Takes> {
        if !pipeline.is_looked_at() {
            return None;
        }
        let memory = pipeline.run.memory.0.saturating_sub(facts.process);
        let workers = Look::workers(pipeline, facts.frame, memory);
        let (count, asked) = (workers as u64, pipeline.run.threads() as u64);
        let stage = |name, workers, asked, queue, memory| StageTakes { name, workers, asked, queue, memory };
        let frames = (2 * pool::most_held(workers, QUEUE) as u64 * facts.frame).min(memory.max(facts.frame));
        let stages = vec![
            stage("frames", 1, 1, 0, frames.max(count * facts.frame)),
            stage("decode", count, asked, QUEUE, 0),
            stage("look", count, asked, QUEUE, 3 * count * WORKER),
            stage("keep", 1, 1, QUEUE, 0),
        ];
        Some(Takes {
            staged: stages.iter().map(|stage| stage.memory).sum::<u64>().min(memory.max(facts.frame + 3 * WORKER)),
            stages,
            held_for: "the mesh",
            needed: facts.frame + 3 * WORKER,
            mapped: facts.mesh + Bvh::BYTES_PER_TRIANGLE * facts.triangles,
            disk: facts.frames * Look::SEEN.min(facts.triangles) * size_of::<Sighting>() as u64,
            units: facts.groups,
            seconds: facts.trial.map(|trial| {
                let looking = SECONDS * (facts.frames * Look::SEEN.min(facts.triangles)) as f64;
                (facts.pixels as f64 * trial.seconds_to_read + looking) / workers as f64
            }),
            ..Takes::default()
        })
    }

    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()> {
        let pipeline = run.pipeline;
        let surveyed = run.known.surveyed()?;
        let groups = Group::of_units(surveyed.groups.looks(), to_do);
        let (ledger, budget, stop) = (Arc::clone(&run.ledger), run.budget.clone(), run.stop.clone());
        let workers = Look::workers(pipeline, surveyed.facts.frame, budget.left());
        let _held = budget.reserve("look", (3 * workers as u64 * WORKER).min(budget.left()))?;
        let (scene, sample) = (&surveyed.scene, surveyed.light.sample());
        let bvh = scene.bvh();
        let decode = scene.decode(pipeline);
        let downscale = pipeline.decode.downscale;
        let looks = look::Look { frames: &scene.frames, mesh: &scene.mesh, bvh: &bvh, sample: &sample, downscale };
        let commits = Commits::new(&ledger, &scene.frames);
        let commit = |group: &_, contents: &_, files| commits.commit(group, contents, files);
        let keep = Keep::new(&groups, Arc::clone(&run.store), &commit);
        let frames = Frames { groups: &groups, decode: decode.clone(), budget: &budget, memory: budget.left() };
        let flow = Flow::source(&stop, "frames", frames)
            .map("decode", decode, workers, QUEUE)
            .map("look", looks, workers, QUEUE)
            .fold("keep", keep, QUEUE);
        run.progress.watch(flow.meters());
        flow.run()?;
        let read = commits.recipes();
        run.known.surveyed_mut()?.groups.settle(&read);
        Ok(())
    }

    fn tell(&self, run: &mut Context<'_>, units: &Units, _: &[Unit]) -> Result<()> {
        for unit in &units.all {
            let files = run.ledger.files(&unit.name).unwrap_or_default();
            run.report.skipped.extend(read_skipped(&*run.store, &files)?);
        }
        run.report.skipped.sort();
        Ok(())
    }
}
