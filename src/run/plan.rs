//! What a run will take: stages, workers, queues, memory, disk and time, worked out before anything starts.
//!
//! Memory is what the run holds at its largest, phase by phase. Where it is short, a phase gets fewer workers; a limit that is
//! too small for one worker is refused. Times are for a run from the start: those of casting and inference from trials on this
//! machine, the rest from the bytes that are read and written.

use std::sync::Arc;

use crate::base::units::Bytes;
use crate::base::{Error, PhaseName, Result};
use crate::disk::space::same_disk;
use crate::disk::{DirStore, Ledger, MemStore, Space, Store};
use crate::flow::pool;
use crate::phases::{Facts, Inputs, Known, LoadedScene, Look, Meshes, PHASES, Phase, Takes};
use crate::pipeline::Pipeline;
use crate::synth::city;

/// What a run will take.
#[derive(Debug, Clone, PartialEq, Default)]
pub struct Plan {
    /// The figures that the plan is made from.
    pub facts: Facts,
    /// The phases that have something to do, in order.
    pub phases: Vec<PlannedPhase>,
    /// The memory limit.
    pub memory: Bytes,
}

/// What a phase will take.
#[derive(Debug, Clone, PartialEq)]
pub struct PlannedPhase {
    /// The phase's name.
    pub name: PhaseName,
    /// What the phase takes beside the process.
    pub takes: Takes,
}

impl Plan {
    /// Plans a run of these phases.
    pub(super) fn new(phases: &[&dyn Phase], pipeline: &Pipeline, facts: Facts) -> Plan {
        let planned =
            |phase: &&dyn Phase| phase.takes(pipeline, &facts).map(|takes| PlannedPhase { name: phase.name(), takes });
        Plan { facts, phases: phases.iter().filter_map(planned).collect(), memory: pipeline.run.memory }
    }

    /// A phase of the plan.
    pub fn of(&self, name: PhaseName) -> Option<&PlannedPhase> {
        self.phases.iter().find(|phase| phase.name == name)
    }

    /// The seconds that the run takes, where all of it could be tried.
    pub fn seconds(&self) -> Option<f64> {
        self.phases.iter().map(|phase| phase.takes.seconds).sum()
    }

    /// The bytes that the run leaves on the disk.
    pub fn disk(&self) -> u64 {
        self.phases.iter().map(|phase| phase.takes.disk).sum()
    }

    /// The most bytes that the run holds, and in which phase.
    pub fn peak(&self) -> Option<(u64, PhaseName)> {
        self.phases.iter().map(|phase| (self.facts.process + phase.takes.peak(), phase.name)).max()
    }

    /// The space that the rest of a run needs in its store.
    pub(super) fn space(&self, phases: &[&dyn Phase], store: &dyn Store, ledger: &Ledger) -> Space {
        let unwritten =
            |phase: &&dyn Phase| self.of(phase.name()).map(|planned| phase.unwritten(&planned.takes, ledger));
        let needs = phases.iter().filter_map(unwritten).sum();
        Space { folder: store.path("").components().collect(), needs, free: store.free() }
    }

    /// Refuses a limit that cannot work.
    ///
    /// # Errors
    /// By how much it is too small, where, and what to change.
    pub fn fits(&self) -> Result<()> {
        let process = self.facts.process;
        let Some(phase) = self.phases.iter().max_by_key(|phase| phase.takes.least()) else { return Ok(()) };
        let needs = process + phase.takes.least();
        if needs <= self.memory.0 {
            return Ok(());
        }
        let (who, hint) = [
            (process, "the process and its model", "choose a smaller [infer] model"),
            (phase.takes.held, phase.takes.held_for, "take a mesh of fewer triangles"),
            (phase.takes.needed, "one frame or shard in work", "take smaller frames, as with [decode] downscale"),
        ]
        .into_iter()
        .max_by_key(|share| share.0)
        .map_or(("", ""), |(_, who, hint)| (who, hint));
        Err(Error::invalid(format!(
            "[run] memory = \"{}\" is {} too small: the phase {} needs {}, most of it for {who}; raise the limit, or {hint}",
            self.memory,
            Bytes(needs - self.memory.0),
            phase.name,
            Bytes(needs),
        )))
    }
}

/// The key that names the run's folder.
pub(super) const WORK: &str = "[run] work";

/// The key that names the city's folder.
const INTO: &str = "[synth] into";

/// A plan, and the space for it.
#[derive(Debug, Clone, PartialEq)]
pub struct Foreseen {
    /// The plan: memory and time of each phase.
    pub plan: Plan,
    /// The space for the run's folder and, where they share a disk, for the city that it is made on.
    pub space: Space,
    /// The space for that city, where it has yet to be made.
    pub city: Option<Space>,
    /// The estimator, in words.
    pub estimator: String,
    /// What is to be told of the inputs, a line each.
    pub inputs: Vec<String>,
}

impl Foreseen {
    /// Refuses a run that cannot work.
    ///
    /// # Errors
    /// A limit or a disk that is too small.
    pub fn works(&self) -> Result<()> {
        self.plan.fits()?;
        self.city.iter().try_for_each(|space| space.enough(INTO))?;
        self.space.enough(WORK)
    }
}

/// Works out what a run will take. Nothing is started and nothing written.
///
/// # Errors
/// Inputs that cannot be read, a model that cannot be used.
pub fn plan(pipeline: &Pipeline) -> Result<Foreseen> {
    plan_phases(PHASES, pipeline)
}

pub(super) fn plan_phases(phases: &[&dyn Phase], pipeline: &Pipeline) -> Result<Foreseen> {
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&pipeline.run.work));
    // Unit records that cannot be read are of no unit that is done: then all is still to be written.
    let read = || Ledger::read(Arc::clone(&store)).or_else(|_| Ledger::read(Arc::new(MemStore::new())));
    let (ledger, _) = pool::share(pipeline.run.threads(), read)??;
    let mut known = Known::new(pipeline)?;
    let refuses = |pipeline: &Pipeline, facts: &Facts| Plan::new(phases, pipeline, *facts).fits();
    let surveyed = known.look(Look::Plan, &store, &ledger, &refuses)?;
    let facts = surveyed.facts;
    let inputs = if pipeline.is_made() { looked_at(pipeline, &surveyed.scene)?.lines() } else { Vec::new() };
    let plan = Plan::new(phases, pipeline, facts);
    let mut space = plan.space(phases, &*store, &ledger);
    let city = pipeline.synth.as_ref().map(|synth| city::space(&synth.into, &synth.city)).transpose()?.flatten();
    let beside = city.iter().filter(|city| same_disk(&city.folder, &space.folder));
    space.needs += beside.map(|city| city.needs).sum::<u64>();
    Ok(Foreseen { plan, space, city, estimator: known.estimator.describe(), inputs })
}

/// Looks at the inputs of a run, without the mesh being held to any limit.
///
/// # Errors
/// Mesh or poses that cannot be read.
pub(crate) fn inputs(pipeline: &Pipeline) -> Result<Inputs> {
    if !pipeline.is_made() {
        return Ok(Inputs::default());
    }
    let store = MemStore::new();
    let ledger = Ledger::read(Arc::new(store.clone()))?.0;
    let scene = pool::share(pipeline.run.threads(), || LoadedScene::read(pipeline, &store, &ledger, Meshes::Any))??;
    looked_at(pipeline, &scene)
}

fn looked_at(pipeline: &Pipeline, scene: &LoadedScene) -> Result<Inputs> {
    pool::share(pipeline.run.threads(), || Inputs::of(pipeline, scene))
}

#[cfg(test)]
mod tests {
    use std::path::Path;

    use super::*;
    use crate::phases::facts::Trial;

    const FACTS: Facts = Facts {
        frames: 100,
        groups: 13,
        pixels: 100_000_000,
        largest: 1_000_000,
        frame: 3_500_000,
        too_large: 0,
        too_large_needs: 0,
        triangles: 250_000,
        mesh: 4_500_000,
        mapped: false,
        process: 50 << 20,
        session: 8 << 20,
        seconds_per_map: 4e-4,
        trial: Some(Trial {
            seconds_to_read: 1e-7,
            seconds_per_pixel: 2.5e-7,
            records_per_pixel: 0.125,
            seconds_per_light: 0.0,
        }),
        threads: 2,
    };

    fn plan(facts: Facts, memory: u64) -> Plan {
        let file = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/demo.toml");
        let set = format!("run.memory={memory}MiB");
        Plan::new(PHASES, &crate::pipeline::load(&file, &[set.into()]).unwrap(), facts)
    }

    fn phase(plan: &Plan, name: PhaseName) -> &Takes {
        &plan.of(name).unwrap().takes
    }

    #[test]
    fn frames_take_time_and_no_memory() {
        let (few, many) = (plan(FACTS, 4096), plan(Facts { frames: 1000, pixels: 1_000_000_000, ..FACTS }, 4096));
        assert_eq!(few.peak(), many.peak());
        assert_eq!(
            phase(&few, PhaseName::Cast).seconds.unwrap() * 10.0,
            phase(&many, PhaseName::Cast).seconds.unwrap()
        );
        assert_eq!(phase(&few, PhaseName::Cast).seconds, Some(12.5));
        assert_eq!(phase(&few, PhaseName::Infer).seconds, Some(50.0));
        // In a known light every triangle takes rays of its own.
        let trial = FACTS.trial.map(|trial| Trial { seconds_per_light: 4e-5, ..trial });
        assert_eq!(phase(&plan(Facts { trial, ..FACTS }, 4096), PhaseName::Infer).seconds, Some(55.0));
    }

    #[test]
    fn what_could_not_be_tried_is_not_known() {
        let blind = plan(Facts { trial: None, ..FACTS }, 4096);
        assert_eq!((blind.seconds(), phase(&blind, PhaseName::Cast).seconds), (None, None));
        assert!(plan(FACTS, 4096).seconds().is_some_and(|s| (62.5..65.0).contains(&s)));
        // As many records as bins, or as were found.
        assert_eq!(phase(&blind, PhaseName::Cast).disk, 250_000 * 16 * 13 * 10);
        assert_eq!(phase(&plan(FACTS, 4096), PhaseName::Cast).disk, 100_000_000 / 8 * 10);
    }

    #[test]
    fn whatever_the_limit_a_plan_that_fits_stays_under_it_and_is_slower_for_it() {
        let crowded = Facts { threads: 16, frame: 40_000_000, largest: 12_000_000, ..FACTS };
        let mut last = f64::INFINITY;
        for memory in (64..4096).step_by(64) {
            let plan = plan(crowded, memory);
            let seconds = plan.seconds().unwrap();
            assert!(seconds <= last, "{memory}");
            last = seconds;
            assert_eq!(plan.fits().is_ok(), plan.peak().unwrap().0 <= memory << 20, "{memory}");
        }
        let (tight, ample) = (plan(crowded, 320), plan(crowded, 1 << 16));
        let workers = |plan: &Plan| phase(plan, PhaseName::Cast).stages[1].workers;
        assert!(workers(&tight) < 16 && workers(&ample) == 16);
        // More memory than helps is not taken.
        assert!(ample.peak().unwrap().0 < 4 << 30);
    }

    #[test]
    fn a_limit_that_cannot_work_is_refused_by_how_much() {
        plan(FACTS, 1024).fits().unwrap();
        let words = |facts, memory| plan(facts, memory).fits().unwrap_err().to_string();
        insta::assert_snapshot!(words(FACTS, 64), @r#"[run] memory = "64 MiB" is 55.1 MiB too small: the phase build needs 119.1 MiB, most of it for the mesh and the hierarchy over it; raise the limit, or take a mesh of fewer triangles"#);
        insta::assert_snapshot!(words(Facts { frame: 900 << 20, threads: 16, ..FACTS }, 512), @r#"[run] memory = "512 MiB" is 478.2 MiB too small: the phase cast needs 990.2 MiB, most of it for one frame or shard in work; raise the limit, or take smaller frames, as with [decode] downscale"#);
        let fine = Facts { triangles: 100_000_000, mesh: 1_800_000_000, ..FACTS };
        insta::assert_snapshot!(words(fine, 4096), @r#"[run] memory = "4 GiB" is 55.4 MiB too small: the phase build needs 4.1 GiB, most of it for the mesh and the hierarchy over it; raise the limit, or take a mesh of fewer triangles"#);
        let mut merging = plan(Facts { triangles: 1_000_000_000, ..FACTS }, 128);
        merging.phases.retain(|phase| phase.name == PhaseName::Merge);
        let why = merging.fits().unwrap_err().to_string();
        assert!(why.contains("the phase merge needs") && why.contains("for what is kept of every triangle"), "{why}");
        // A mesh that is mapped already takes none.
        plan(Facts { mapped: true, mesh: 1 << 40, ..FACTS }, 256).fits().unwrap();
    }
}
