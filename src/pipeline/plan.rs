//! What a run will take: stages, workers, queues, memory and time, worked out before anything starts.
//!
//! Memory is what the run holds at its largest, phase by phase. The folds that can spill (gather) take what is left;
//! everything else is needed, and a limit below that is refused. Times are for a run from the start: inference from a
//! trial of the estimator on this machine, the rest from [`RAYS_PER_SECOND`] and [`BYTES_PER_SECOND`].

use std::time::Instant;

use super::Pipeline;
use super::scene::Loaded;
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::cache;
use crate::flow::pool;
use crate::model::Estimator;
use crate::scene::Material;
use crate::scene::reflectance::{BINS, BinSum, FRONT_BINS};
use crate::shard::Record;
use crate::shard::format::SHARD;
use crate::stages::merge::Materials;
use crate::trace::Bvh;

/// Items that wait between two stages.
pub const QUEUE: usize = 1;

/// Rays that one thread casts and gathers in a second, in photographs of real scenes.
pub const RAYS_PER_SECOND: f64 = 4e6;

/// Bytes of mesh that are read, and of exports that are written, in a second.
pub const BYTES_PER_SECOND: f64 = 100e6;

/// Bins that flights fill of a triangle's map; measured medians are 12 and 16.
const USUAL_BINS: u64 = 16;

/// Bytes on disk per record of a segment, measured.
const RECORD_ON_DISK: u64 = 10;

/// What the plan is made from.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Inputs {
    /// Posed frames.
    pub frames: u64,
    /// Pixels of all of them.
    pub pixels: u64,
    /// Pixels of the largest.
    pub largest: u64,
    /// Triangles.
    pub triangles: u64,
    /// Bytes of the mesh in memory.
    pub mesh: u64,
    /// Channels of the model.
    pub channels: u64,
    /// Bytes that the estimator holds for all workers.
    pub estimator: u64,
    /// What one map takes one worker.
    pub seconds_per_map: f64,
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
    /// Items that may wait for it; 0 for a source.
    pub queue: usize,
    /// Bytes that it needs.
    pub memory: u64,
    /// Bytes that it takes beyond if they are to be had, and spills if not.
    pub elastic: u64,
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
    /// What it takes.
    pub seconds: f64,
}

impl Phase {
    /// Bytes that it cannot do without.
    pub fn needs(&self) -> u64 {
        self.held + self.stages.iter().map(|s| s.memory).sum::<u64>()
    }

    /// Bytes that it holds at most under a limit.
    pub fn peak(&self, limit: u64) -> u64 {
        let wants = self.needs() + self.stages.iter().map(|s| s.elastic).sum::<u64>();
        wants.min(limit).max(self.needs())
    }
}

/// What a run will take.
#[derive(Debug, Clone, PartialEq)]
pub struct Plan {
    /// What it is made from.
    pub inputs: Inputs,
    /// The phases, in order.
    pub phases: Vec<Phase>,
    /// The limit.
    pub memory: Bytes,
    /// Bytes on disk: the scene cache, segments, shards, tables and exports.
    pub disk: u64,
}

impl Inputs {
    /// Takes stock of a scene and tries the estimator on a batch.
    ///
    /// # Errors
    /// What the estimator says when it refuses.
    pub fn of(pipeline: &Pipeline, loaded: &Loaded, estimator: &dyn Estimator) -> Result<Inputs> {
        let scale = u64::from(pipeline.decode.downscale);
        let pixels =
            |f: &crate::scene::frame::Frame| (u64::from(f.camera.width) / scale) * (u64::from(f.camera.height) / scale);
        let threads = pool::threads(pipeline.run.threads, pool::available());
        Ok(Inputs {
            frames: loaded.frames.len() as u64,
            pixels: loaded.frames.iter().map(pixels).sum(),
            largest: loaded.frames.iter().map(pixels).max().unwrap_or(0),
            triangles: loaded.mesh.len() as u64,
            mesh: loaded.bytes(),
            channels: estimator.contract().channels as u64,
            estimator: estimator.memory(threads).0,
            seconds_per_map: trial(estimator)?,
            threads: threads as u64,
        })
    }
}

/// What one map takes, seconds: one batch to warm up, then one by the clock.
fn trial(estimator: &dyn Estimator) -> Result<f64> {
    let (count, size) = (estimator.micro_batch(), estimator.contract().channels * BINS);
    let mut maps = vec![0.0; count * size];
    for (n, map) in maps.chunks_exact_mut(size).enumerate() {
        for bin in (0..USUAL_BINS as usize).map(|i| (n * 37 + i * 211) % FRONT_BINS) {
            map.iter_mut().skip(bin).step_by(BINS).for_each(|v| *v = 0.5);
        }
    }
    let mut session = estimator.session()?;
    let mut answers = vec![Material::default(); count];
    session.estimate(&maps, None, &mut answers)?;
    let started = Instant::now();
    session.estimate(&maps, None, &mut answers)?;
    Ok(started.elapsed().as_secs_f64() / count as f64)
}

impl Plan {
    /// Plans a run of this pipeline on these inputs.
    pub fn new(pipeline: &Pipeline, inputs: Inputs) -> Plan {
        let i = inputs;
        let stage = |name, workers, memory| Stage { name, workers, queue: QUEUE, memory, elastic: 0 };
        let source = |name| Stage { queue: 0, ..stage(name, 1, 0) };
        // A frame's pixels: the file's bytes, three samples and the mask.
        let image = 7 * i.largest;
        // A frame rarely sees a triangle in more than two bins, and never in more than its pixels.
        let rows = i.largest.min(2 * i.triangles) * size_of::<Record>() as u64;
        let group = u64::from(pipeline.gather.group).min(i.frames);
        let map = USUAL_BINS * size_of::<(u16, BinSum)>() as u64;
        let shard = u64::from(SHARD).min(i.triangles) * map;
        let batch = u64::from(pipeline.infer.batch) * i.channels * (BINS * size_of::<f32>()) as u64;
        let tables = Materials::BYTES_PER_TRIANGLE * i.triangles;
        let bvh = Bvh::BYTES_PER_TRIANGLE * i.triangles;
        let held = pool::most_held(i.threads as usize, QUEUE) as u64;
        let threads = i.threads as f64;
        let export = i.triangles as f64 * (EXPORTED * pipeline.export.formats.len() as u64) as f64;

        let cast = Phase {
            name: "cast",
            stages: vec![
                source("frames"),
                stage("decode", i.threads, held * image),
                stage("cast", i.threads, held * rows.max(image) + i.threads * rows),
                Stage { elastic: (group - 1) * rows, ..stage("gather", 1, rows) },
            ],
            held: 0,
            mapped: i.mesh + bvh,
            seconds: i.pixels as f64 / (threads * RAYS_PER_SECOND),
        };
        let infer = Phase {
            name: "infer",
            stages: vec![
                source("shards"),
                stage("infer", i.threads, i.estimator + i.threads * (batch + shard) + 2 * shard),
                stage("keep", 1, shard),
            ],
            held: 0,
            mapped: 0,
            seconds: i.triangles as f64 * i.seconds_per_map / threads,
        };
        let alone = |name, held, mapped, seconds| Phase { name, stages: Vec::new(), held, mapped, seconds };
        let neighbours = NEIGHBOURS * i.triangles;
        let building = cache::building(i.triangles, (i.mesh / VERTEX).saturating_sub(i.triangles));
        let phases = vec![
            alone("load", i.mesh, 0, i.mesh as f64 / BYTES_PER_SECOND),
            alone("build", i.mesh + building, 0, bvh as f64 / BYTES_PER_SECOND),
            cast,
            infer,
            alone("merge", tables, neighbours, tables as f64 / BYTES_PER_SECOND),
            alone("export", 2 * tables, i.mesh, export / BYTES_PER_SECOND),
        ];
        let records = i.triangles * USUAL_BINS * i.frames.div_ceil(group).min(USUAL_BINS);
        let scene = i.mesh + bvh + neighbours;
        let disk = records.min(i.pixels) * RECORD_ON_DISK + scene + 2 * tables + export as u64;
        Plan { inputs, phases, memory: pipeline.run.memory, disk }
    }

    /// The bytes that the run holds at its largest, and in which phase.
    pub fn peak(&self) -> (u64, &'static str) {
        self.phases.iter().map(|p| (p.peak(self.memory.0), p.name)).max().unwrap_or_default()
    }

    /// Refuses a limit that cannot work.
    ///
    /// # Errors
    /// By how much it is too small, where, and what to change.
    pub fn fits(&self) -> Result<()> {
        let most = self.phases.iter().max_by_key(|p| p.needs());
        let Some(phase) = most.filter(|p| p.needs() > self.memory.0) else { return Ok(()) };
        let largest = phase.stages.iter().max_by_key(|s| s.memory).filter(|s| s.memory > phase.held);
        let (who, hint) = match largest.map(|s| s.name) {
            Some("decode" | "cast") => ("its frames in flight", "fewer [run] threads"),
            Some("infer") => ("its batches", "a smaller [infer] batch or fewer [run] threads"),
            _ => ("the mesh", "a mesh of fewer triangles"),
        };
        Err(Error::invalid(format!(
            "[run] memory = \"{}\" is {} too small: the phase {} needs {}, most of it for {who}; give it more, or {hint}",
            self.memory,
            Bytes(phase.needs() - self.memory.0),
            phase.name,
            Bytes(phase.needs()),
        )))
    }
}

/// Bytes of a vertex in memory, and of a triangle.
const VERTEX: u64 = 12;

/// Bytes that the neighbours of a triangle take.
const NEIGHBOURS: u64 = 16;

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
        triangles: 250_000,
        mesh: 4_500_000,
        channels: 4,
        estimator: 50 << 20,
        seconds_per_map: 4e-4,
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
        assert_eq!(phase(&few, "cast").seconds * 10.0, phase(&many, "cast").seconds);
        assert_eq!(phase(&few, "cast").seconds, 12.5);
        assert_eq!(phase(&few, "infer").seconds, 50.0);
    }

    #[test]
    fn what_can_spill_takes_what_is_left() {
        let cast = |memory| phase(&plan(INPUTS, memory), "cast").peak(memory << 20);
        let needs = phase(&plan(INPUTS, 1), "cast").needs();
        assert!(cast(4096) > needs && cast(1) == needs);
        let between = (needs >> 20) + 10;
        assert_eq!(cast(between), between << 20);
    }

    #[test]
    fn a_limit_that_cannot_work_is_refused_by_how_much() {
        plan(INPUTS, 1024).fits().unwrap();
        insta::assert_snapshot!(plan(INPUTS, 64).fits().unwrap_err(), @r#"[run] memory = "64 MiB" is 96.2 MiB too small: the phase cast needs 160.2 MiB, most of it for its frames in flight; give it more, or fewer [run] threads"#);
        let large = Inputs { largest: 150_000_000, threads: 16, ..INPUTS };
        insta::assert_snapshot!(plan(large, 4096).fits().unwrap_err(), @r#"[run] memory = "4 GiB" is 58.9 GiB too small: the phase cast needs 62.9 GiB, most of it for its frames in flight; give it more, or fewer [run] threads"#);
        let fine = Inputs { triangles: 100_000_000, mesh: 1_800_000_000, ..INPUTS };
        insta::assert_snapshot!(plan(fine, 4096).fits().unwrap_err(), @r#"[run] memory = "4 GiB" is 8.7 GiB too small: the phase export needs 12.7 GiB, most of it for the mesh; give it more, or a mesh of fewer triangles"#);
    }
}
