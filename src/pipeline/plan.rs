//! What a run will take: stages, workers, queues, memory and time, worked out before anything starts.
//!
//! Memory is what the run holds at its largest, phase by phase. Where it is short, a phase gets fewer workers
//! (`share`); a limit that one worker cannot do with is refused. Times are for a run from the start: those of casting
//! and inference from trials on this machine (`trial`), the rest from [`BYTES_PER_SECOND`].

use std::collections::BTreeSet;
use std::time::Instant;

use glam::Vec3;

use super::Pipeline;
use super::readable::{self, Readable};
use super::room::Disk;
use super::scene::Loaded;
use super::share::{CastInputs, InferInputs};
use super::trial::Trial;
use crate::base::units::Bytes;
use crate::base::{Error, Result, memory};
use crate::cache;
use crate::flow::pool;
use crate::model::{Estimate, Estimator, Session};
use crate::scene::Material;
use crate::scene::evidence::Evidence;
use crate::scene::frame::Frame;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{Bin, BinSum, FRONT_BINS, SparseMap};
use crate::shard::Record;
use crate::shard::format::SHARD;
use crate::shard::rows::ROW;
use crate::stages::merge;
use crate::trace::Bvh;

/// Items that wait between two stages.
pub const QUEUE: usize = 1;

/// Bytes of mesh that are read, and of exports that are written, in a second.
pub const BYTES_PER_SECOND: f64 = 100e6;

/// Bins that flights fill of a triangle's map; measured medians are 12 and 16.
const USUAL_BINS: u64 = 16;

/// Bytes on disk per record of a segment, measured: 9.3 to 10.
const RECORD_ON_DISK: u64 = 10;

/// What the plan is made from.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub struct Inputs {
    /// Posed frames.
    pub frames: u64,
    /// Pixels of all of them.
    pub pixels: u64,
    /// Pixels of the largest.
    pub largest: u64,
    /// Bytes that reading a frame takes, at most, of those that are not too large.
    pub frame: u64,
    /// How many frames are too large to be read under the limit, and the bytes that the largest of them takes.
    pub too_large: (u64, u64),
    /// Triangles.
    pub triangles: u64,
    /// Bytes of the mesh in memory.
    pub mesh: u64,
    /// Whether it is mapped from a cache that is there: then it is neither read nor prepared.
    pub mapped: bool,
    /// Bytes that the process holds before it reads a scene, the estimator included.
    pub base: u64,
    /// Bytes that the estimator holds for each worker.
    pub session: u64,
    /// What one map takes one worker.
    pub seconds_per_map: f64,
    /// What frames take, where any could be tried.
    pub trial: Option<Trial>,
    /// Threads.
    pub threads: u64,
}

/// One stage.
#[derive(Debug, Clone, PartialEq)]
pub struct Stage {
    /// Its name.
    pub name: &'static str,
    /// Its threads.
    pub workers: u64,
    /// The threads that it would have if memory were not short.
    pub asked: u64,
    /// Items that may wait for it; 0 for a source.
    pub queue: usize,
    /// Bytes that it is given.
    pub memory: u64,
}

/// Stages that run together.
#[derive(Debug, Clone, PartialEq)]
pub struct Phase {
    /// Its name.
    pub name: &'static str,
    /// Its stages, in order.
    pub stages: Vec<Stage>,
    /// Bytes that are held all along.
    pub held: u64,
    /// Bytes of files that are mapped on top: the system may drop and read them again.
    pub mapped: u64,
    /// Bytes that it takes in all, at most.
    pub peak: u64,
    /// Bytes that it cannot do without.
    pub needs: u64,
    /// What it takes, where that could be tried.
    pub seconds: Option<f64>,
}

/// What a run will take.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// What it is made from.
    pub inputs: Inputs,
    /// The phases, in order.
    pub phases: Vec<Phase>,
    /// The limit.
    pub memory: Bytes,
    /// What it leaves on the disk.
    pub disk: Disk,
    /// What the cast phase shares its memory by.
    pub cast: CastInputs,
    /// What the infer phase shares its memory by.
    pub infer: InferInputs,
}

impl Inputs {
    /// Takes stock of a scene and tries the estimator on a batch. `trial` is left out: it comes last.
    ///
    /// # Errors
    /// What the estimator says when it refuses.
    pub fn of(
        pipeline: &Pipeline,
        loaded: &Loaded,
        estimator: &dyn Estimator,
        base: u64,
        fit: &Readable,
    ) -> Result<Inputs> {
        let pixels = |f: &Frame| readable::pixels(pipeline, f);
        let threads = pool::threads(pipeline.run.threads, pool::available());
        let before = memory::resident().unwrap_or(0);
        let (seconds_per_map, session) = trial(estimator)?;
        let grown = memory::resident().unwrap_or(0).saturating_sub(before);
        drop(session);
        Ok(Inputs {
            frames: loaded.frames.len() as u64,
            pixels: loaded.frames.iter().map(pixels).sum(),
            largest: loaded.frames.iter().map(pixels).max().unwrap_or(0),
            frame: fit.largest(),
            too_large: fit.too_large(),
            triangles: loaded.mesh.len() as u64,
            mesh: loaded.bytes(),
            mapped: loaded.is_mapped(),
            base,
            session: (estimator.memory(1).0 - estimator.memory(0).0).max(grown),
            seconds_per_map,
            trial: None,
            threads: threads as u64,
        })
    }
}

/// Bytes that the process holds now, and that the allocator may keep of small blocks. To be asked once the estimator is
/// there and before a scene is.
pub fn base() -> u64 {
    memory::trim();
    memory::resident().unwrap_or(USUAL_BASE) + KEPT
}

/// What a process holds that does not say.
const USUAL_BASE: u64 = 48 << 20;

/// Bytes of small blocks that the allocator keeps, the curves of a transfer, and the stacks of threads beside workers.
const KEPT: u64 = 24 << 20;

/// What one map takes, seconds: one batch to warm up, then one by the clock. The session is given too, as it is then.
fn trial(estimator: &dyn Estimator) -> Result<(f64, Box<dyn Session>)> {
    let usual = |n: usize| -> BTreeSet<Bin> {
        (0..USUAL_BINS as usize).map(|i| ((n * 37 + i * 211) % FRONT_BINS) as Bin).collect()
    };
    let seen = BinSum::one([0.5; 3], false);
    let map = |n: usize| SparseMap { bins: usual(n).into_iter().map(|bin| (bin, seen)).collect() };
    let maps: Vec<SparseMap> = (0..TRIED.next_multiple_of(estimator.micro_batch())).map(map).collect();
    let maps: Vec<&SparseMap> = maps.iter().collect();
    let mut session = estimator.session()?;
    let mut answers = vec![Estimate::default(); maps.len()];
    let light = LocalLight { direction: Vec3::Z, sun: Vec3::ONE, sky: Vec3::ZERO };
    let lights = vec![light; maps.len()];
    let lights = estimator.contract().light.wanted().then_some(lights.as_slice());
    session.estimate(&maps, lights, &mut answers)?;
    let started = Instant::now();
    session.estimate(&maps, lights, &mut answers)?;
    Ok((started.elapsed().as_secs_f64() / maps.len() as f64, session))
}

/// Maps of a trial.
const TRIED: usize = 16;

impl Plan {
    /// Plans a run of this pipeline on these inputs.
    pub fn new(pipeline: &Pipeline, inputs: Inputs) -> Plan {
        let (i, limit) = (inputs, pipeline.run.memory.0);
        let scratch = (Material::LEN * size_of::<f32>()) as u64 * i.triangles;
        let tables = scratch + (Evidence::LEN * size_of::<f32>()) as u64 * i.triangles;
        let bvh = Bvh::BYTES_PER_TRIANGLE * i.triangles;
        let group = u64::from(pipeline.gather.group).min(i.frames);
        let cast = CastInputs {
            workers: i.threads as usize,
            frame: i.frame,
            // A frame rarely sees a triangle in more than two bins, and never in more than its pixels.
            rows: i.largest.min(2 * i.triangles) * Record::BYTES,
            group,
            tile: pipeline.cast.tile,
        };
        let shard = u64::from(SHARD).min(i.triangles);
        let infer = InferInputs {
            workers: i.threads as usize,
            session: i.session,
            // Four segments hold a bin, in vectors half full.
            shard: 8 * shard * USUAL_BINS * size_of::<(u16, BinSum)>() as u64,
            // A block as it is decoded, of the group that saw the most.
            least: 4 * shard * USUAL_BINS * size_of::<(u16, BinSum)>() as u64,
            rows: 2 * shard * ROW as u64,
        };
        let export = i.triangles as f64 * (EXPORTED * pipeline.export.formats.len() as u64) as f64;
        let alone = |name, held: u64, mapped, seconds| {
            let held = i.base + held;
            Phase { name, stages: Vec::new(), held, mapped, peak: held, needs: held, seconds: Some(seconds) }
        };
        let neighbours = NEIGHBOURS * i.triangles;
        let building = cache::building(i.triangles, (i.mesh / VERTEX).saturating_sub(i.triangles));
        let seconds = i.trial.map(|trial| i.pixels as f64 * trial.seconds_per_pixel);
        let lighting = i.trial.map_or(0.0, |trial| trial.seconds_per_light);
        let casting = Phase { mapped: i.mesh + bvh, ..plan_cast(&cast, i.base, limit, seconds) };
        let inferring = plan_infer(&infer, i.base, limit, i.triangles as f64 * (i.seconds_per_map + lighting));
        let phases = vec![
            alone("load", i.mesh, 0, i.mesh as f64 / BYTES_PER_SECOND),
            alone("build", i.mesh + building, 0, bvh as f64 / BYTES_PER_SECOND),
            casting,
            inferring,
            // The scratch of the materials is mapped, and so are the neighbours; a shard's rows are few.
            alone("merge", merge::bytes(i.triangles), neighbours + scratch, 2.0 * tables as f64 / BYTES_PER_SECOND),
            alone("export", EXPORTING, i.mesh + tables, export / BYTES_PER_SECOND),
        ];
        let records = i.triangles * USUAL_BINS * i.frames.div_ceil(group).min(USUAL_BINS);
        // Frames of a group that see a triangle from about the same side share its records, which makes them fewer.
        let seen = i.trial.map_or(i.pixels, |trial| (i.pixels as f64 * trial.records_per_pixel) as u64);
        let exports = pipeline.export.formats.len() as u64;
        let disk = Disk {
            scene: i.mesh + bvh + neighbours,
            segments: records.min(seen) * RECORD_ON_DISK,
            rows: tables,
            // Where triangles are filled, the materials come to lie in scratch first.
            tables: tables + if pipeline.merge.fill { scratch } else { 0 },
            export: EXPORTED * i.triangles,
            exports,
            frames: i.frames,
            shards: i.triangles.div_ceil(u64::from(SHARD)),
        };
        // What is not done takes no memory.
        let done = |phase: &Phase| match phase.name {
            "load" | "build" => !i.mapped,
            "export" => exports > 0,
            _ => true,
        };
        let phases = phases.into_iter().filter(done).collect();
        Plan { inputs, phases, memory: pipeline.run.memory, disk, cast, infer }
    }

    /// What the run takes, where all of it could be tried.
    pub fn seconds(&self) -> Option<f64> {
        self.phases.iter().map(|p| p.seconds).sum()
    }

    /// The bytes that the run holds at its largest, and in which phase.
    pub fn peak(&self) -> (u64, &'static str) {
        self.phases.iter().map(|p| (p.peak, p.name)).max().unwrap_or_default()
    }

    /// Refuses a limit that cannot work.
    ///
    /// # Errors
    /// By how much it is too small, where, and what to change.
    pub fn fits(&self) -> Result<()> {
        let most = self.phases.iter().max_by_key(|p| p.needs);
        let Some(phase) = most.filter(|p| p.needs > self.memory.0) else { return Ok(()) };
        let i = &self.inputs;
        let what = match phase.name {
            "build" => "the mesh and the hierarchy over it",
            "merge" | "export" => "what is kept of every triangle",
            _ => "the mesh",
        };
        let (who, hint) = [
            (i.base, "the process and its model", "choose a smaller [infer] model"),
            (phase.held - i.base, what, "take a mesh of fewer triangles"),
            (phase.needs - phase.held, "one frame or shard in work", "take smaller frames, as with [decode] downscale"),
        ]
        .into_iter()
        .max_by_key(|part| part.0)
        .map_or(("", ""), |(_, who, hint)| (who, hint));
        Err(Error::invalid(format!(
            "[run] memory = \"{}\" is {} too small: the phase {} needs {}, most of it for {who}; give it more, or {hint}",
            self.memory,
            Bytes(phase.needs - self.memory.0),
            phase.name,
            Bytes(phase.needs),
        )))
    }
}

/// The cast phase beside what is `held` all along; where it does not fit, as one worker would need it. `seconds` is what
/// one worker takes.
fn plan_cast(inputs: &CastInputs, held: u64, limit: u64, seconds: Option<f64>) -> Phase {
    let left = limit.saturating_sub(held);
    let asked = inputs.workers as u64;
    let missing = inputs.share(0).err().unwrap_or(0);
    let share = inputs.share(left).or_else(|_| inputs.share(missing)).unwrap_or_default();
    let workers = share.workers as u64;
    // Frames do not take more than all that can be under way.
    let most = 2 * pool::most_held(share.workers, QUEUE) as u64 * inputs.frame;
    let frames = share.frames.min(most.max(workers * inputs.frame));
    let stage = |name, workers, asked, queue, memory| Stage { name, workers, asked, queue, memory };
    let stages = vec![
        stage("frames", 1, 1, 0, frames),
        stage("decode", workers, asked, QUEUE, 0),
        stage("cast", workers, asked, QUEUE, share.casting),
        stage("gather", 1, 1, QUEUE, share.gather + share.compressing),
    ];
    let peak = held + stages.iter().map(|s| s.memory).sum::<u64>();
    let seconds = seconds.map(|seconds| seconds / workers.max(1) as f64);
    Phase { name: "cast", stages, held, mapped: 0, peak, needs: held + missing, seconds }
}

/// The infer phase, likewise.
fn plan_infer(inputs: &InferInputs, held: u64, limit: u64, seconds: f64) -> Phase {
    let left = limit.saturating_sub(held);
    let asked = inputs.workers as u64;
    let missing = inputs.share(0).err().unwrap_or(0);
    let share = inputs.share(left).or_else(|_| inputs.share(missing)).unwrap_or_default();
    let workers = share.workers as u64;
    let shards = share.shards.min((pool::most_held(share.workers, QUEUE) as u64 + 1) * inputs.shard);
    let stage = |name, workers, asked, queue, memory| Stage { name, workers, asked, queue, memory };
    let stages = vec![
        stage("shards", 1, 1, 0, shards),
        stage("infer", workers, asked, QUEUE, share.inferring),
        stage("keep", 1, 1, QUEUE, 0),
    ];
    let peak = held + stages.iter().map(|s| s.memory).sum::<u64>();
    let seconds = Some(seconds / workers.max(1) as f64);
    Phase { name: "infer", stages, held, mapped: 0, peak, needs: held + missing, seconds }
}

/// Bytes of a vertex in memory, and of a triangle.
const VERTEX: u64 = 12;

/// Bytes that the neighbours of a triangle take.
const NEIGHBOURS: u64 = 16;

/// Bytes of memory that an export holds: rows of pictures, and what is written and not yet on its way.
const EXPORTING: u64 = 2 << 20;

/// Bytes that an export takes per triangle.
const EXPORTED: u64 = 100;

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;

    const INPUTS: Inputs = Inputs {
        frames: 100,
        pixels: 100_000_000,
        largest: 1_000_000,
        frame: 3_500_000,
        too_large: (0, 0),
        triangles: 250_000,
        mesh: 4_500_000,
        mapped: false,
        base: 50 << 20,
        session: 8 << 20,
        seconds_per_map: 4e-4,
        trial: Some(Trial { seconds_per_pixel: 2.5e-7, records_per_pixel: 0.125, seconds_per_light: 0.0 }),
        threads: 2,
    };

    fn plan(inputs: Inputs, memory: u64) -> Plan {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/demo.toml");
        let set = format!("run.memory={memory}MiB");
        Plan::new(&super::super::check::load(&file, &[set]).unwrap(), inputs)
    }

    fn phase<'a>(plan: &'a Plan, name: &str) -> &'a Phase {
        plan.phases.iter().find(|p| p.name == name).unwrap()
    }

    #[test]
    fn frames_take_time_and_no_memory() {
        let (few, many) = (plan(INPUTS, 4096), plan(Inputs { frames: 1000, pixels: 1_000_000_000, ..INPUTS }, 4096));
        assert_eq!(few.peak(), many.peak());
        assert_eq!(phase(&few, "cast").seconds.unwrap() * 10.0, phase(&many, "cast").seconds.unwrap());
        assert_eq!(phase(&few, "cast").seconds, Some(12.5));
        assert_eq!(phase(&few, "infer").seconds, Some(50.0));
        // In a known light every triangle takes rays of its own.
        let trial = INPUTS.trial.map(|trial| Trial { seconds_per_light: 4e-5, ..trial });
        assert_eq!(phase(&plan(Inputs { trial, ..INPUTS }, 4096), "infer").seconds, Some(55.0));
    }

    #[test]
    fn what_could_not_be_tried_is_not_known() {
        let blind = plan(Inputs { trial: None, ..INPUTS }, 4096);
        assert_eq!((blind.seconds(), phase(&blind, "cast").seconds), (None, None));
        assert!(plan(INPUTS, 4096).seconds().is_some_and(|s| (62.5..65.0).contains(&s)));
        // As many records as bins, or as were found.
        assert_eq!(blind.disk.segments, 250_000 * 16 * 13 * 10);
        assert_eq!(plan(INPUTS, 4096).disk.segments, 100_000_000 / 8 * 10);
    }

    #[test]
    fn whatever_the_limit_a_plan_that_fits_stays_under_it_and_is_slower_for_it() {
        let crowded = Inputs { threads: 16, frame: 40_000_000, largest: 12_000_000, ..INPUTS };
        let mut last = f64::INFINITY;
        for memory in (64..4096).step_by(64) {
            let plan = plan(crowded, memory);
            let seconds = plan.seconds().unwrap();
            assert!(seconds <= last, "{memory}");
            last = seconds;
            assert_eq!(plan.fits().is_ok(), plan.peak().0 <= memory << 20, "{memory}");
        }
        let (tight, ample) = (plan(crowded, 320), plan(crowded, 1 << 16));
        let workers = |plan: &Plan| phase(plan, "cast").stages[1].workers;
        assert!(workers(&tight) < 16 && workers(&ample) == 16);
        // More memory than helps is not taken.
        assert!(ample.peak().0 < 4 << 30);
    }

    #[test]
    fn a_limit_that_cannot_work_is_refused_by_how_much() {
        plan(INPUTS, 1024).fits().unwrap();
        let words = |inputs, memory| plan(inputs, memory).fits().unwrap_err().to_string();
        insta::assert_snapshot!(words(INPUTS, 64), @r#"[run] memory = "64 MiB" is 55.1 MiB too small: the phase build needs 119.1 MiB, most of it for the mesh and the hierarchy over it; give it more, or take a mesh of fewer triangles"#);
        insta::assert_snapshot!(words(Inputs { frame: 900 << 20, threads: 16, ..INPUTS }, 512), @r#"[run] memory = "512 MiB" is 477.5 MiB too small: the phase cast needs 989.5 MiB, most of it for one frame or shard in work; give it more, or take smaller frames, as with [decode] downscale"#);
        let fine = Inputs { triangles: 100_000_000, mesh: 1_800_000_000, ..INPUTS };
        insta::assert_snapshot!(words(fine, 4096), @r#"[run] memory = "4 GiB" is 55.4 MiB too small: the phase build needs 4.1 GiB, most of it for the mesh and the hierarchy over it; give it more, or take a mesh of fewer triangles"#);
        let mut merging = plan(Inputs { triangles: 1_000_000_000, ..INPUTS }, 128);
        merging.phases.retain(|phase| phase.name == "merge");
        let why = merging.fits().unwrap_err().to_string();
        assert!(why.contains("the phase merge needs") && why.contains("for what is kept of every triangle"), "{why}");
        // A mesh that is mapped already takes none.
        plan(Inputs { mapped: true, mesh: 1 << 40, ..INPUTS }, 256).fits().unwrap();
    }
}
