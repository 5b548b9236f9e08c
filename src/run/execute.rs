//! Runs a pipeline: phase after phase, of each the units that the ledger lacks.

use std::collections::BTreeSet;
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::mend::Mending;
use super::plan::{Plan, WORK};
use crate::base::units::Bytes;
use crate::base::{Error, PhaseName, Result, memory};
use crate::disk::{DirStore, Finding, Findings, Ledger, Lock, Store, UnitName};
use crate::flow::{Budget, Reservation, StopSignal, pool};
use crate::phases::{
    Context, Extent, Facts, Known, PHASES, Phase, PhaseReport, Progress, REPORT, Report, StageReport, Unit, UnitCount,
    end_light, remove_report, write_report,
};
use crate::pipeline::Pipeline;

/// Runs or resumes the pipeline to its end.
///
/// # Errors
/// Whatever breaks the run; `Error::Interrupted` if it was asked to stop.
pub fn run(pipeline: &Pipeline, stop: &StopSignal, progress: &Progress) -> Result<Report> {
    let store = DirStore::new(&pipeline.run.work);
    let _lock = Lock::acquire(&store)?;
    run_phases(PHASES, Arc::new(store), pipeline, stop, progress)
}

/// Runs or resumes the pipeline as far as to the light: exposures and light are found, and nothing is made of them. With `again`,
/// what was found before is ended first.
///
/// # Errors
/// As for [`run`].
pub fn find_light(pipeline: &Pipeline, again: bool, stop: &StopSignal, progress: &Progress) -> Result<Report> {
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&pipeline.run.work));
    let _lock = Lock::acquire(&DirStore::new(&pipeline.run.work))?;
    if again {
        end_light(&store)?;
    }
    let to_light: Vec<&dyn Phase> =
        PHASES.iter().copied().take_while(|phase| phase.name() <= PhaseName::Light).collect();
    run_phases(&to_light, store, pipeline, stop, progress)
}

/// Runs these phases on the store of the run's folder, which is locked: what no unit record names is swept first.
pub(super) fn run_phases(
    phases: &[&dyn Phase],
    store: Arc<dyn Store>,
    pipeline: &Pipeline,
    stop: &StopSignal,
    progress: &Progress,
) -> Result<Report> {
    let threads = pipeline.run.threads();
    let ledger = Arc::new(pool::share(threads, || opened(phases, &store, progress))??);
    repaired(phases, &store, &ledger, pipeline, stop, progress)
}

/// Opens the ledger, tells what was found to be wrong, and sweeps.
fn opened(phases: &[&dyn Phase], store: &Arc<dyn Store>, progress: &Progress) -> Result<Ledger> {
    let (ledger, findings) = Ledger::open(Arc::clone(store))?;
    let Findings { corrupt, lost } = findings;
    for Finding { unit, why, kept, .. } in corrupt.into_iter().chain(lost) {
        let kept = kept.map_or_else(String::new, |kept| format!("; the corrupt file is now {kept}"));
        progress.note(format!("unit {unit} is done over: {why}{kept}"));
    }
    ledger.sweep()?;
    let outputs: Vec<&str> = phases.iter().flat_map(|phase| phase.outputs()).chain([REPORT]).collect();
    for kept in ledger.clear(&outputs)? {
        progress.note(format!("a folder, a link or a device had the name of a file of the run's, and is now {kept}"));
    }
    Ok(ledger)
}

/// Runs the phases. A file that turns out to be corrupt is set aside, and the unit that it belonged to is done over: at once, and
/// once for each file.
pub(super) fn repaired(
    phases: &[&dyn Phase],
    store: &Arc<dyn Store>,
    ledger: &Arc<Ledger>,
    pipeline: &Pipeline,
    stop: &StopSignal,
    progress: &Progress,
) -> Result<Report> {
    let started = Instant::now();
    let mut mending = Mending::new(&**store, ledger, progress);
    loop {
        match attempt(phases, store, ledger, pipeline, &stop.again(), started, &mut mending) {
            Ok(report) => return Ok(report),
            Err(why) => mending.after(why)?,
        }
    }
}

/// Goes on from what is done to the end.
fn attempt(
    phases: &[&dyn Phase],
    store: &Arc<dyn Store>,
    ledger: &Arc<Ledger>,
    pipeline: &Pipeline,
    stop: &StopSignal,
    started: Instant,
    mending: &mut Mending<'_>,
) -> Result<Report> {
    let refuses = |pipeline: &Pipeline, facts: &Facts| Plan::new(phases, pipeline, *facts).fits();
    // The estimator is loaded before anything costly starts.
    let known = Known::new(pipeline)?;
    let report =
        Report { gonio: env!("CARGO_PKG_VERSION").into(), backend: known.estimator.describe(), ..Report::default() };
    let context = Context {
        pipeline,
        stop: stop.clone(),
        progress: mending.progress,
        store: Arc::clone(store),
        ledger: Arc::clone(ledger),
        budget: Budget::new(pipeline.run.memory, stop),
        refuses: &refuses,
        known,
        report,
    };
    let mut run = Run { phases, context, mending, plan: None, process: None };
    let done = run.all().and_then(|()| run.end(started));
    done.map_err(|why| run.told_if_full(why))?;
    Ok(run.context.report)
}

/// Whether a run holds the files of a phase from before against their records: what people open always, the rest if asked.
fn run_verifies(pipeline: &Pipeline, phase: &dyn Phase) -> bool {
    pipeline.run.verify || !phase.outputs().is_empty()
}

/// A run under way.
struct Run<'a, 'm> {
    phases: &'a [&'a dyn Phase],
    context: Context<'a>,
    mending: &'a mut Mending<'m>,
    /// What the run will take, once the scene is known.
    plan: Option<Plan>,
    /// The reservation of the memory that the process itself holds, kept as long as the run lasts.
    process: Option<Reservation>,
}

impl Run<'_, '_> {
    fn all(&mut self) -> Result<()> {
        for phase in self.phases {
            self.one(*phase)?;
            if self.plan.is_none()
                && let Ok(surveyed) = self.context.known.surveyed()
            {
                let facts = surveyed.facts;
                self.plan(facts)?;
            }
        }
        Ok(())
    }

    /// Does a phase: the units that it lacks, shown and timed, and the report of all.
    fn one(&mut self, phase: &dyn Phase) -> Result<()> {
        let run = &mut self.context;
        phase.prepare(run)?;
        let units = phase.units(&run.known, &*run.store, &run.ledger)?;
        match units.extent {
            Extent::Absent => return Ok(()),
            Extent::Unkept => return self.timed(phase, &[]),
            Extent::Exact | Extent::AtLeast | Extent::Renewed => {}
        }
        let wanted: BTreeSet<_> = units.all.iter().map(|unit| unit.name).collect();
        let stale = run.ledger.of_phase(phase.name()).into_iter().filter(|unit| !wanted.contains(unit));
        let stale: Vec<UnitName> = stale.collect();
        let (before, to_do): (Vec<Unit>, Vec<Unit>) =
            units.all.iter().cloned().partition(|unit| run.ledger.is_done(&unit.name));
        if !stale.is_empty() || !to_do.is_empty() {
            remove_report(&*run.store)?;
        }
        run.ledger.forget(stale)?;
        if !to_do.is_empty() {
            self.timed(phase, &to_do)?;
        }
        // IMPORTANT: before anything is made of them.
        if run_verifies(self.context.pipeline, phase) {
            self.mending.check(phase.name(), &before, &self.context.stop)?;
        }
        let run = &mut self.context;
        // What was read may be other than what was there before, and then so is the unit.
        let units = phase.units(&run.known, &*run.store, &run.ledger)?;
        let is_done = |unit: &&Unit| to_do.iter().any(|begun| begun.recipe.what() == unit.recipe.what());
        let done: Vec<Unit> = units.all.iter().filter(is_done).cloned().collect();
        phase.tell(run, &units, &done)
    }

    fn timed(&mut self, phase: &dyn Phase, to_do: &[Unit]) -> Result<()> {
        let run = &mut self.context;
        if run.stop.draining() {
            return Err(Error::Interrupted);
        }
        let started = Instant::now();
        run.progress.begin(phase.name());
        phase.work(run, to_do)?;
        let stages = run.progress.end().map(|told| told.meters).unwrap_or_default();
        // What one phase has freed is not held through the next.
        memory::trim();
        run.report.phases.push(PhaseReport { name: phase.name(), seconds: started.elapsed().as_secs_f64() });
        run.report.stages.extend(stages.iter().map(|meter| StageReport::of(phase.name(), meter)));
        Ok(())
    }

    /// Plans what is left, now that the scene is known; refuses a limit or a disk that is too small.
    fn plan(&mut self, facts: Facts) -> Result<()> {
        let run = &mut self.context;
        let plan = Plan::new(self.phases, run.pipeline, facts);
        plan.space(self.phases, &*run.store, &run.ledger).enough(WORK)?;
        let begun: Vec<PhaseName> = run.report.phases.iter().map(|phase| phase.name).collect();
        let later = plan.phases.iter().filter(|planned| !begun.contains(&planned.name));
        let expected = later.map(|p| (p.name, Duration::from_secs_f64(p.takes.seconds.unwrap_or_default())));
        run.progress.expect(&expected.collect::<Vec<_>>());
        self.process = Some(run.budget.reserve("process", facts.process)?);
        self.plan = Some(plan);
        Ok(())
    }

    /// Writes the report, which says that a run is finished: not after some of the phases.
    fn end(&mut self, started: Instant) -> Result<()> {
        let whole = self.phases.iter().any(|phase| phase.name() >= PhaseName::Merge);
        let run = &mut self.context;
        run.report.memory_peak = run.budget.peak();
        run.report.seconds = started.elapsed().as_secs_f64();
        run.report.units = UnitCount::of(self.phases.iter().map(|phase| phase.name()), &run.ledger);
        if whole { write_report(&*run.store, &run.report) } else { Ok(()) }
    }

    /// The same error, and what to do where the disk is full or a file is too large for a limit.
    fn told_if_full(&self, why: Error) -> Error {
        if why.is_file_too_large() {
            let doing = "the system allows no file of that size (ulimit -f, or the disk's format): raise the limit, and the same \
                         command goes on from here";
            return why.doing(doing);
        }
        if !why.is_disk_full() {
            return why;
        }
        let run = &self.context;
        let nothing = Plan::default();
        let space = self.plan.as_ref().unwrap_or(&nothing).space(self.phases, &*run.store, &run.ledger);
        why.doing(format!(
            "the disk of {} is full, and about {} is still to be written there: free that much, and the same command goes on \
             from here",
            run.pipeline.run.work.display(),
            Bytes(space.needs)
        ))
    }
}
