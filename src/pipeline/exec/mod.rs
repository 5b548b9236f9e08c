//! Runs a pipeline: the map side, from frames to segments, then the reduce side, from segments to materials, then the
//! exports. What the manifest already has is not done again.

mod map;
mod reduce;

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::plan::Inputs;
use super::report::{Phase, Stage, Triangles};
use super::scene::Loaded;
use super::{Pipeline, Plan, Progress, Report, resume};
use crate::base::{Error, Result};
use crate::disk::{DirStore, Lock, Manifest, Store};
use crate::flow::{Budget, Meter, StopSignal};
use crate::model::{self, Estimator};
use crate::scene::evidence::Filled;
use crate::scene::reflectance::Kind;
use crate::stages::export;
use crate::stages::gather::{self, SEGMENTS};
use crate::stages::merge::{EVIDENCE, MATERIALS, Materials};
use crate::stages::shards::SHARDS;
use crate::synth::city;

pub use map::segments;
pub use reduce::read_materials;

/// What the run did.
const REPORT: &str = "report.json";
/// The folder of exports.
const EXPORT: &str = "export";

/// A run under way: what its phases share.
struct Run<'a> {
    pipeline: &'a Pipeline,
    stop: &'a StopSignal,
    progress: &'a Progress,
    store: Arc<dyn Store>,
    budget: Budget,
    threads: usize,
    report: Report,
}

/// Runs or resumes the pipeline to its end.
///
/// # Errors
/// Whatever breaks the run; `Error::Interrupted` if it was asked to stop.
pub fn run(pipeline: &Pipeline, stop: &StopSignal, progress: &Progress) -> Result<Report> {
    let started = Instant::now();
    let work = &pipeline.run.work;
    let _lock = Lock::acquire(work)?;
    let store: Arc<dyn Store> = Arc::new(DirStore::new(work));
    let (mut manifest, opening) = Manifest::open(Arc::clone(&store), &[SEGMENTS, SHARDS, MATERIALS, EVIDENCE])?;
    if let Some((file, why)) = &opening.set_aside {
        progress.note(format!("the manifest could not be used and is now {file}: {why}"));
    }
    for (unit, why) in &opening.lost {
        progress.note(format!("unit {unit} is done again: {why}"));
    }
    let budget = Budget::new(pipeline.run.memory, stop);
    let report = Report { gonio: env!("CARGO_PKG_VERSION").into(), ..Report::default() };
    let mut run = Run { pipeline, stop, progress, store, budget, threads: 0, report };

    if let Some(synth) = &pipeline.synth {
        let made = |run: &mut Run<'_>| city::generate_if_needed(&synth.into, &synth.city, &|| run.stop.draining());
        run.phase("synth", vec![], made)?;
    }
    // The network is tried before anything costly starts.
    let estimator = estimator(pipeline)?;
    run.report.backend = estimator.describe();
    let (loaded, groups) = run.phase("load", vec![], |run| {
        let loaded = Loaded::read(run.pipeline)?;
        let plan = Plan::new(run.pipeline, Inputs::of(run.pipeline, &loaded, &*estimator)?);
        plan.fits()?;
        run.threads = plan.inputs.threads as usize;
        let later = plan.phases.iter().filter(|p| p.name != "load");
        let expected: Vec<_> = later.map(|p| (p.name, Duration::from_secs_f64(p.seconds))).collect();
        run.progress.expect(&expected);
        let groups = resume::groups(run.pipeline, loaded.mesh_key, &loaded.frames);
        Ok((loaded, groups))
    })?;
    resume::forget_others(&mut manifest, gather::UNIT, |unit| groups.iter().any(|g| g.unit() == unit))?;

    run.map(&loaded, &groups, &mut manifest)?;
    let (materials, held) = run.reduce(&loaded, &groups, &*estimator, &mut manifest)?;
    run.phase("export", vec![], |run| {
        let folder = run.pipeline.run.work.join(EXPORT);
        run.report.outputs = export::write(&run.pipeline.export, &loaded.mesh, &materials, &folder)?;
        Ok(())
    })?;
    drop(held);
    run.finish(&loaded, &materials, started)
}

/// Loads the network and checks that it eats what scenes give.
pub fn estimator(pipeline: &Pipeline) -> Result<Box<dyn Estimator>> {
    let config = &pipeline.infer;
    let estimator = model::load(&config.model.source(), config.backend, config.library.as_deref())?;
    estimator.contract().require(Kind::Lobe)?;
    if estimator.contract().light {
        return Err(Error::invalid(format!(
            "{} wants to know the light, and [light] mode is \"unknown\": choose a model without a `light` input",
            estimator.describe()
        )));
    }
    Ok(estimator)
}

impl Run<'_> {
    /// Does one phase, shown and timed.
    fn phase<T>(
        &mut self,
        name: &str,
        meters: Vec<Arc<Meter>>,
        work: impl FnOnce(&mut Self) -> Result<T>,
    ) -> Result<T> {
        if self.stop.draining() {
            return Err(Error::Interrupted);
        }
        let started = Instant::now();
        self.progress.begin(name, meters.clone());
        let done = work(self)?;
        self.progress.end();
        self.report.phases.push(Phase { name: name.to_owned(), seconds: started.elapsed().as_secs_f64() });
        self.report.stages.extend(meters.iter().map(|meter| Stage::of(name, meter)));
        Ok(done)
    }

    fn finish(mut self, loaded: &Loaded, materials: &Materials, started: Instant) -> Result<Report> {
        self.report.triangles = Triangles {
            total: loaded.mesh.len() as u64,
            degenerate: loaded.mesh.degenerate() as u64,
            seen: materials.count(Filled::Observed),
            filled: materials.count(Filled::Neighbours) + materials.count(Filled::SceneMean),
            empty: materials.count(Filled::Nothing),
        };
        self.report.memory_peak = self.budget.peak();
        self.report.seconds = started.elapsed().as_secs_f64();
        let path = self.pipeline.run.work.join(REPORT);
        crate::disk::write_atomic(&path, |out| {
            serde_json::to_writer_pretty(out, &self.report).map_err(|e| Error::io("write", &path)(e.into()))
        })?;
        Ok(self.report)
    }
}

/// Works out what a run will take. Nothing is started and nothing written.
///
/// # Errors
/// Inputs that cannot be read, a model that cannot be used.
pub fn plan(pipeline: &Pipeline) -> Result<(Plan, String)> {
    let estimator = estimator(pipeline)?;
    let loaded = Loaded::expected(pipeline)?;
    Ok((Plan::new(pipeline, Inputs::of(pipeline, &loaded, &*estimator)?), estimator.describe()))
}

/// The scene and the materials of a finished run.
///
/// # Errors
/// No finished materials, or those of another mesh; anything that cannot be read.
pub fn finished(pipeline: &Pipeline) -> Result<(Loaded, Materials)> {
    let materials =
        read_materials(pipeline).map_err(|e| e.doing("looking for a finished run (`gonio run` makes one)"))?;
    let loaded = Loaded::read(pipeline)?;
    if loaded.mesh.len() != materials.rows.len() {
        return Err(Error::invalid(format!(
            "{} has {} rows, and {} has {} triangles: run the pipeline again",
            pipeline.run.work.join(MATERIALS).display(),
            materials.rows.len(),
            pipeline.scene.mesh.display(),
            loaded.mesh.len()
        )));
    }
    Ok((loaded, materials))
}

/// Writes the exports again from the materials of a finished run, and gives their paths.
///
/// # Errors
/// No finished materials; anything that cannot be read or written.
pub fn export(pipeline: &Pipeline) -> Result<Vec<PathBuf>> {
    let (loaded, materials) = finished(pipeline)?;
    export::write(&pipeline.export, &loaded.mesh, &materials, &pipeline.run.work.join(EXPORT))
}

/// A file that is to be written where the user said: its folder must be there.
pub fn writable(out: &Path) -> Result<()> {
    let folder = out.parent().filter(|p| !p.as_os_str().is_empty());
    match folder {
        Some(folder) if !folder.is_dir() => {
            Err(Error::invalid(format!("{}: there is no folder {}: make it first", out.display(), folder.display())))
        }
        _ => Ok(()),
    }
}
