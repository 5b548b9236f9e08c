//! A phase that nobody foresaw: it is put into the list, and everything knows it.

use std::sync::Arc;

use super::scene;
use crate::base::{PhaseName, Result};
use crate::disk::Recipe;
use crate::disk::{Ledger, MemStore, Store};
use crate::flow::StopSignal;
use crate::phases::takes::StageTakes;
use crate::phases::{Cause, Context, Extent, Facts, Known, PHASES, Phase, Progress, State, Takes, Unit, Units};
use crate::pipeline::Pipeline;
use crate::run::execute::run_phases;
use crate::run::explain::explain_phases;
use crate::run::plan::plan_phases;

/// Counts the frames of the scene into a file of its own.
struct Mock;

impl Phase for Mock {
    fn name(&self) -> PhaseName {
        PhaseName::Mock
    }

    fn units(&self, known: &Known<'_>, _: &dyn Store, _: &Ledger) -> Result<Units> {
        let recipe = Recipe::new(PhaseName::Mock, "count").with("frames", known.surveyed()?.facts.frames);
        Ok(Units { noun: "counts", all: vec![Unit::new(recipe)], extent: Extent::Exact })
    }

    fn takes(&self, _: &Pipeline, facts: &Facts) -> Option<Takes> {
        let stage = StageTakes { name: "count", workers: 1, asked: 1, queue: 0, memory: 1 << 20 };
        let disk = 1 << 30;
        let (staged, seconds) = (stage.memory, Some(facts.frames as f64));
        Some(Takes { stages: vec![stage], staged, disk, units: 1, seconds, ..Takes::default() })
    }

    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()> {
        for unit in to_do {
            let draft = run.store.create(&format!("mock/{}.{}", unit.name, run.store.attempt()))?;
            run.commit(&unit.recipe, vec![draft.commit()?])?;
        }
        Ok(())
    }

    fn tell(&self, run: &mut Context<'_>, _: &Units, done: &[Unit]) -> Result<()> {
        run.report.rays += 1000 * done.len() as u64;
        Ok(())
    }
}

#[test]
fn plan_explain_run_progress_and_report_know_a_phase_by_the_list_alone() {
    let (dir, pipeline) = scene();
    let phases: Vec<&dyn Phase> = PHASES.iter().copied().chain([&Mock as &dyn Phase]).collect();

    let (without, with) = (plan_phases(PHASES, &pipeline).unwrap(), plan_phases(&phases, &pipeline).unwrap());
    let planned = with.plan.of(PhaseName::Mock).unwrap();
    assert_eq!((planned.takes.stages.len(), planned.takes.seconds), (1, Some(4.0)));
    assert_eq!(with.plan.disk() - without.plan.disk(), 1 << 30);
    assert_eq!(with.space.needs - without.space.needs, 1 << 30);

    let explained = explain_phases(&phases, &pipeline).unwrap();
    let last = explained.phases.last().unwrap();
    assert_eq!((last.name, last.total, last.again), (PhaseName::Mock, Some(1), 1));
    assert_eq!(last.causes, [Cause::New]);

    let store = MemStore::new();
    let run = || {
        let progress = Progress::new();
        let shared: Arc<dyn Store> = Arc::new(store.clone());
        let report = run_phases(&phases, shared, &pipeline, &StopSignal::new(), &progress).unwrap();
        (report, progress.phases())
    };
    let (report, told) = run();
    let last = told.last().unwrap();
    assert!(last.name == PhaseName::Mock && matches!(last.state, State::Done(_)) && last.expected.as_secs() == 4);
    assert_eq!(report.phases.last().unwrap().name, PhaseName::Mock);
    // Done once: the next run finds the unit, and sweeps what no unit record names.
    super::put(&store, "mock/rubbish.none-1", b"left behind");
    let (again, _) = run();
    assert!(again.phases.iter().all(|phase| phase.name != PhaseName::Mock));
    assert_eq!((report.rays, again.rays), (4 * 48 * 32 + 1000, 0));
    assert_eq!(store.list("mock").unwrap().len(), 1);
    drop(dir);
}
