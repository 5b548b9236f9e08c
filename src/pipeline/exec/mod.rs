//! Runs a pipeline: the map side, from frames to segments, then the reduce side, from segments to materials, then the
//! exports. What the manifest already has is not done again.

mod export;
mod map;
mod reduce;
#[cfg(test)]
mod tests;

use std::collections::BTreeSet;
use std::io::Write;
use std::path::Path;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::plan::{self, Inputs};
use super::readable::Readable;
use super::report::{Phase, Stage, Triangles};
use super::room::room;
use super::scene::{self, Loaded, SCENES};
use super::trial::Trial;
use super::{Pipeline, Plan, Progress, Report, resume};
use crate::base::units::Bytes;
use crate::base::{Error, Result, memory};
use crate::disk::room::same_disk;
use crate::disk::{DirStore, Lock, Manifest, MemStore, Opening, Room, Store};
use crate::flow::{Budget, Meter, StopSignal};
use crate::model::{self, Estimator, Fit};
use crate::scene::evidence::Filled;
use crate::scene::reflectance::Kind;
use crate::stages::export::Format;
use crate::stages::gather::{FRAMES, SEGMENTS};
use crate::stages::merge::{EVIDENCE, MATERIALS};
use crate::stages::shards::SHARDS;
use crate::stages::{infer, light};
use crate::synth::city;

pub use export::{export, finished};
pub use map::segments;

/// What names the run's folder.
const WORK: &str = "[run] work";
/// What names the city's.
const INTO: &str = "into in [synth]";

/// What the run did.
const REPORT: &str = "report.json";

/// A run under way: what its phases share.
struct Run<'a> {
    pipeline: &'a Pipeline,
    stop: StopSignal,
    progress: &'a Progress,
    store: Arc<dyn Store>,
    budget: Budget,
    plan: Plan,
    report: Report,
}

/// Runs or resumes the pipeline to its end.
///
/// # Errors
/// Whatever breaks the run; `Error::Interrupted` if it was asked to stop.
pub fn run(pipeline: &Pipeline, stop: &StopSignal, progress: &Progress) -> Result<Report> {
    let _lock = Lock::acquire(&pipeline.run.work)?;
    run_on(Arc::new(DirStore::new(&pipeline.run.work)), pipeline, stop, progress)
}

/// Runs the pipeline on the store of its folder, which is locked. A file that turns out to be corrupt is set aside, and
/// what it belonged to is done again: at once, and once for each file.
fn run_on(store: Arc<dyn Store>, pipeline: &Pipeline, stop: &StopSignal, progress: &Progress) -> Result<Report> {
    let started = Instant::now();
    let mut manifest = open(&store, progress)?;
    let mut repaired = BTreeSet::new();
    loop {
        let run = Run::new(Arc::clone(&store), pipeline, &stop.again(), progress);
        let why = match run.attempt(&mut manifest, started) {
            Ok(report) => return Ok(report),
            Err(why) => why,
        };
        let Some(file) = why.malformed_file().filter(|file| repaired.insert(file.to_path_buf())) else {
            return Err(why);
        };
        let Some((unit, kept)) = manifest.set_aside(file)? else { return Err(why) };
        progress.note(format!("unit {unit} is done again, its corrupt file is now {kept}: {why}"));
    }
}

/// Opens the manifest of a run, and tells what was found to be wrong.
fn open(store: &Arc<dyn Store>, progress: &Progress) -> Result<Manifest> {
    let exports = Format::ALL.map(Format::file);
    let mut owned = vec![SCENES, SEGMENTS, SHARDS, MATERIALS, EVIDENCE];
    owned.extend(exports.iter().map(String::as_str));
    let (manifest, Opening { set_aside, copied, lost, .. }) = Manifest::open(Arc::clone(store), &owned)?;
    if let Some((file, why)) = set_aside {
        let then = if copied { "its copy stands in for it" } else { "everything is done again" };
        progress.note(format!("the manifest could not be used and is now {file}, {then}: {why}"));
    }
    for (unit, why) in lost {
        progress.note(format!("unit {unit} is done again: {why}"));
    }
    Ok(manifest)
}

/// Makes the estimator. A network is loaded, and must eat what scenes give.
pub fn estimator(pipeline: &Pipeline) -> Result<Box<dyn Estimator>> {
    let kind = pipeline.infer.estimator;
    let network = kind.has_network().then(|| network(pipeline)).transpose()?;
    Ok(match network {
        Some(network) if kind == infer::Kind::Network => network,
        network => Box::new(Fit::new(network)),
    })
}

fn network(pipeline: &Pipeline) -> Result<Box<dyn Estimator>> {
    let config = &pipeline.infer;
    let network = model::load(&config.model.source(), config.backend, config.library.as_deref())?;
    network.contract().require(Kind::Lobe)?;
    if network.contract().light.wanted() && pipeline.light.mode == light::Mode::Unknown {
        return Err(Error::invalid(format!(
            "{} wants to know the light, and [light] mode is \"unknown\": make it known, or choose a model without a `light` input",
            network.describe()
        )));
    }
    Ok(network)
}

impl<'a> Run<'a> {
    fn new(store: Arc<dyn Store>, pipeline: &'a Pipeline, stop: &StopSignal, progress: &'a Progress) -> Self {
        let budget = Budget::new(pipeline.run.memory, stop);
        let report = Report { gonio: env!("CARGO_PKG_VERSION").into(), ..Report::default() };
        Run { pipeline, stop: stop.clone(), progress, store, budget, plan: Plan::default(), report }
    }

    /// Goes on from what the manifest has to the end.
    fn attempt(mut self, manifest: &mut Manifest, started: Instant) -> Result<Report> {
        let done = self.do_all(manifest).and_then(|()| self.write_report(started));
        done.map_err(|why| self.told_if_full(why, manifest))?;
        Ok(self.report)
    }

    fn write_report(&mut self, started: Instant) -> Result<()> {
        self.report.memory_peak = self.budget.peak();
        self.report.seconds = started.elapsed().as_secs_f64();
        let mut draft = self.store.create(REPORT)?;
        serde_json::to_writer_pretty(&mut draft, &self.report)
            .map_err(std::io::Error::from)
            .and_then(|()| draft.write_all(b"\n"))
            .map_err(Error::io("write", self.store.path(REPORT)))?;
        draft.replace().map(drop)
    }

    fn do_all(&mut self, manifest: &mut Manifest) -> Result<()> {
        if let Some(synth) = &self.pipeline.synth {
            let made = |run: &mut Self| city::generate_if_needed(&synth.into, &synth.city, &|| run.stop.draining());
            self.phase("synth", vec![], made)?;
        }
        // The network is tried before anything costly starts.
        let estimator = estimator(self.pipeline)?;
        self.report.backend = estimator.describe();
        let base = plan::base();
        let (mut loaded, groups) = self.phase("load", vec![], |run| {
            let loaded = Loaded::open(run.pipeline, &*run.store, manifest, base)?;
            let fit = Readable::of(run.pipeline, &loaded, base);
            let mut inputs = Inputs::of(run.pipeline, &loaded, &*estimator, base, &fit)?;
            Plan::new(run.pipeline, inputs).fits()?;
            let groups = resume::groups(run.pipeline, manifest, loaded.mesh_key, &loaded.frames, Some(&fit));
            // Where nothing is cast, there is nothing to foretell.
            if !resume::to_do(manifest, &groups).is_empty() {
                inputs.trial = Trial::of(run.pipeline, &loaded, base, &fit, estimator.contract().light.wanted())?;
            }
            let plan = Plan::new(run.pipeline, inputs);
            room(&*run.store, manifest, &plan.disk).enough(WORK)?;
            let later = plan.phases.iter().filter(|p| p.name != "load");
            let expected: Vec<_> =
                later.map(|p| (p.name, Duration::from_secs_f64(p.seconds.unwrap_or_default()))).collect();
            run.progress.expect(&expected);
            run.plan = plan;
            Ok((loaded, groups))
        })?;
        let _process = self.budget.reserve("process", base)?;
        resume::forget_others(manifest, FRAMES, groups.iter().map(|group| &group.recipe))?;
        resume::forget_others(manifest, scene::SCENE, [&scene::recipe(loaded.mesh_key)])?;

        if !loaded.is_mapped() {
            let _held = self.budget.reserve("scene", loaded.mesh.held() + loaded.building())?;
            let cache = |run: &mut Self| loaded.cache(&*run.store, manifest, &|| run.stop.draining());
            self.phase("build", vec![], cache)?;
        }
        self.map(&loaded, &groups, manifest)?;
        let (materials, tables) = self.reduce(&loaded, &groups, &*estimator, manifest)?;
        self.export(&tables, &loaded.mesh, &materials, manifest)?;
        let counts = materials.counts();
        let of = |filled: Filled| counts[filled as usize];
        self.report.triangles = Triangles {
            total: loaded.mesh.len() as u64,
            degenerate: loaded.degenerate(),
            seen: of(Filled::Observed),
            filled: of(Filled::Neighbours) + of(Filled::SceneMean),
            empty: of(Filled::Nothing),
        };
        Ok(())
    }

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
        // What one phase has freed is not held through the next.
        memory::trim();
        self.report.phases.push(Phase { name: name.to_owned(), seconds: started.elapsed().as_secs_f64() });
        self.report.stages.extend(meters.iter().map(|meter| Stage::of(name, meter)));
        Ok(done)
    }

    /// The same error, and what to do where the disk is full.
    fn told_if_full(&self, why: Error, manifest: &Manifest) -> Error {
        if !why.is_disk_full() {
            return why;
        }
        let room = room(&*self.store, manifest, &self.plan.disk);
        why.doing(format!(
            "the disk of {} is full, and about {} is still to be written there: free that much, and the same command goes \
             on from here",
            self.pipeline.run.work.display(),
            Bytes(room.needs)
        ))
    }
}

/// What a run will take.
pub struct Foreseen {
    /// Memory and time.
    pub plan: Plan,
    /// The room for the run's folder and, where they share a disk, for the city that it is made on.
    pub room: Room,
    /// The room for that city, where it has yet to be made.
    pub city: Option<Room>,
    /// The estimator, in words.
    pub estimator: String,
}

impl Foreseen {
    /// Refuses a run that cannot work.
    ///
    /// # Errors
    /// A limit or a disk that is too small.
    pub fn works(&self) -> Result<()> {
        self.plan.fits()?;
        self.city.iter().try_for_each(|room| room.enough(INTO))?;
        self.room.enough(WORK)
    }
}

/// Works out what a run will take. Nothing is started and nothing written.
///
/// # Errors
/// Inputs that cannot be read, a model that cannot be used.
pub fn plan(pipeline: &Pipeline) -> Result<Foreseen> {
    let estimator = estimator(pipeline)?;
    let base = plan::base();
    let loaded = Loaded::planned(pipeline, base)?;
    let fit = Readable::of(pipeline, &loaded, base);
    let mut inputs = Inputs::of(pipeline, &loaded, &*estimator, base, &fit)?;
    if Plan::new(pipeline, inputs).fits().is_ok() {
        inputs.trial = Trial::of(pipeline, &loaded, base, &fit, estimator.contract().light.wanted())?;
    }
    let plan = Plan::new(pipeline, inputs);
    let store = DirStore::new(&pipeline.run.work);
    // A manifest that cannot be read names nothing: then all is still to be written.
    let manifest = Manifest::read(Arc::new(store.clone())).or_else(|_| Manifest::read(Arc::new(MemStore::new())))?;
    let mut room = room(&store, &manifest, &plan.disk);
    let city = pipeline.synth.as_ref().map(|synth| city::room(&synth.into, &synth.city)).transpose()?.flatten();
    room.needs += city.iter().filter(|city| same_disk(&city.folder, &room.folder)).map(|city| city.needs).sum::<u64>();
    Ok(Foreseen { plan, room, city, estimator: estimator.describe() })
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
