//! The power is cut: what was not synced is lost, in whole or in any part. Whatever was lost, every unit that is believed is
//! whole, and the next run gives the bytes of an undisturbed one, as if nothing had been.
//!
//! A run is recorded once, and the disk after a cut is made up from that (`disk::power`).
//! `GONIO_POWER_CUTS=N` tries N seeds instead of a few; `GONIO_POWER_CUT=SEED` replays one.

use std::fs;
use std::path::Path;
use std::sync::Arc;

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use tempfile::TempDir;

use super::inputs::thin;
use super::{outputs, scene, seeds};
use crate::base::PhaseName;
use crate::disk::journal::{Journal, Step};
use crate::disk::names::TEMPORARY;
use crate::disk::power::{Disk, Loss};
use crate::disk::{DirStore, Ledger, Store};
use crate::flow::StopSignal;
use crate::phases::{Progress, REPORT};
use crate::pipeline::Pipeline;
use crate::run::run;

/// Seeds that are tried unless more are asked for.
const FEW: u64 = 100;

/// A scene, what a run does to its folder, and what comes out.
struct Tried {
    _scene: TempDir,
    pipeline: Pipeline,
    steps: Vec<Step>,
    expected: Vec<Vec<u8>>,
}

impl Tried {
    fn new() -> Self {
        let (scene, pipeline) = scene();
        thin(&scene.path().join("mesh.ply"));
        let mut tried = Tried { _scene: scene, pipeline, steps: Vec::new(), expected: Vec::new() };
        let folder = folder();
        let journal = Journal::of(folder.path());
        tried.goes_on(folder.path()).unwrap();
        tried.steps = journal.steps();
        tried.expected = outputs(&store(folder.path()));
        tried
    }

    /// What a cut after some steps leaves.
    fn cut(&self, steps: &[Step], loss: &mut Loss) -> TempDir {
        let left = folder();
        let mut disk = Disk::of(left.path());
        steps.iter().for_each(|step| disk.step(step));
        disk.cut(loss, left.path());
        left
    }

    /// Runs in a folder, by the code that `gonio run` uses, and gives what it had to say.
    fn goes_on(&self, folder: &Path) -> Result<Vec<String>, String> {
        let mut pipeline = self.pipeline.clone();
        pipeline.run.work = store(folder).root().to_owned();
        let progress = Progress::new();
        run(&pipeline, &StopSignal::new(), &progress).map_err(|why| why.to_string())?;
        Ok(progress.take_notes())
    }

    /// All steps of a run that is killed after some and of the next one, and where that begins.
    fn killed(&self, after: usize) -> Result<(Vec<Step>, usize), String> {
        let folder = folder();
        let journal = Journal::of(folder.path());
        journal.ends_after(after);
        let why = self.goes_on(folder.path()).err();
        let killed = journal.steps().len();
        assert!(why.is_some() || killed < after, "the end was passed over");
        journal.ends_after(usize::MAX);
        self.goes_on(folder.path())?;
        Ok((journal.steps(), killed))
    }

    /// Goes on from what a cut left.
    fn survives(&self, folder: &Path) -> Result<(), String> {
        let _unsynced = Journal::of(folder);
        is_whole(folder)?;
        let notes = self.goes_on(folder)?;
        if !notes.is_empty() {
            return Err(format!("the run had something to mend: {notes:?}"));
        }
        if outputs(&store(folder)) != self.expected {
            return Err("the outputs differ".to_owned());
        }
        let names = fs::read_dir(store(folder).root()).unwrap().map(|entry| entry.unwrap().file_name());
        let left = names.filter_map(|name| name.into_string().ok()).find(|name| {
            // What a broken taking of the folder left has no run's name.
            name.ends_with(TEMPORARY) && !name.starts_with("gonio-run.")
        });
        left.map_or_else(|| is_whole(folder), |name| Err(format!("{name} is left")))
    }
}

fn folder() -> TempDir {
    TempDir::new().unwrap()
}

fn store(folder: &Path) -> DirStore {
    DirStore::new(fs::canonicalize(folder).unwrap().join("work"))
}

/// Whether all that is believed is as it was written.
fn is_whole(folder: &Path) -> Result<(), String> {
    let store = store(folder);
    let (ledger, findings) = Ledger::read(Arc::new(store.clone())).map_err(|why| why.to_string())?;
    if !findings.is_empty() {
        return Err(format!("a unit has a record and is not done: {findings:?}"));
    }
    let units = PhaseName::ALL.iter().flat_map(|phase| ledger.of_phase(*phase));
    let mut files = units.flat_map(|unit| ledger.files(&unit).unwrap().to_vec());
    files.try_for_each(|file| file.check(&store).map_err(|why| format!("a torn file is believed: {why}")))
}

#[test]
fn a_cut_at_any_step_costs_no_byte() {
    let tried = Tried::new();
    let all = &tried.steps;
    assert!(all.len() > 150, "{} steps", all.len());
    for at in 0..=all.len() {
        for mut loss in [Loss::Nothing, Loss::Everything, Loss::seeded(at as u64)] {
            let how = format!("{loss:?}");
            let left = tried.cut(&all[..at], &mut loss);
            tried.survives(left.path()).unwrap_or_else(|why| {
                panic!("a cut before step {at}, {:?}, that loses {how}: {why}", all.get(at).map(name_of))
            });
        }
    }
    println!("{} cuts", 3 * (all.len() + 1));
}

#[test]
fn cuts_that_lose_anything_cost_no_byte() {
    let tried = Tried::new();
    for seed in seeds("GONIO_POWER_CUT", "GONIO_POWER_CUTS", FEW) {
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| seeded(&tried, seed)));
        let why = done.unwrap_or_else(|_| Err("a panic".to_owned())).err();
        assert_eq!(
            why, None,
            "seed {seed}: replay it with\n  GONIO_POWER_CUT={seed} cargo test --lib cuts_that_lose_anything"
        );
    }
}

/// The page cache outlives the process, and so does what is not durable: the next run builds on it.
#[test]
fn a_kill_while_the_folder_is_taken_and_then_a_cut_cost_no_byte() {
    let tried = Tried::new();
    let is_lock = |step: &Step| matches!(step, Step::Rewrite(..));
    let taken = tried.steps.iter().position(is_lock).unwrap() + 1;
    for kill in 1..=taken {
        let (steps, killed) = tried.killed(kill).unwrap();
        for at in killed..killed + 6 {
            for mut loss in [Loss::Everything, Loss::seeded(at as u64), Loss::seeded(1000 + at as u64)] {
                let left = tried.cut(&steps[..at], &mut loss);
                tried.survives(left.path()).unwrap_or_else(|why| {
                    let shown: Vec<String> = steps[..at].iter().map(name_of).collect();
                    panic!("a kill before step {kill} and a cut before step {at}: {why}\n{}", shown.join("\n"))
                });
            }
        }
    }
}

/// What a run found of one that was killed is as durable in the end as what it did itself.
#[test]
fn what_a_killed_and_then_finished_run_left_stays() {
    let tried = Tried::new();
    let units = |steps: &[Step]| {
        let left = tried.cut(steps, &mut Loss::Everything);
        is_whole(left.path()).unwrap();
        let store = store(left.path());
        let there = store.size(REPORT).unwrap().is_some() && outputs(&store) == tried.expected;
        (there, store.list("units").unwrap().len(), store.list("groups").unwrap().len())
    };
    let whole = units(&tried.steps);
    assert!(whole.0 && whole.1 > 5 && whole.2 == 1, "{whole:?}");
    for kill in (0..=24).chain((25..tried.steps.len()).step_by(3)) {
        let (steps, _) = tried.killed(kill).unwrap();
        assert_eq!(units(&steps), whole, "after a kill before step {kill}, {:?}", tried.steps.get(kill).map(name_of));
    }
}

/// One cut, a kill and then a cut, or a cut and then another one while the next run mends.
fn seeded(tried: &Tried, seed: u64) -> Result<(), String> {
    let mut random = SmallRng::seed_from_u64(seed);
    // The first steps take the folder: there are few, and each is its own.
    let any = |random: &mut SmallRng, all: usize| match random.random_bool(0.3) {
        true => random.random_range(0..=all.min(20)),
        false => random.random_range(0..=all),
    };
    let mut loss = Loss::seeded(random.random());
    let left = match random.random_range(0..3) {
        0 => tried.cut(&tried.steps[..any(&mut random, tried.steps.len())], &mut loss),
        1 => {
            let (steps, killed) = tried.killed(any(&mut random, tried.steps.len()))?;
            let at = killed + any(&mut random, steps.len() - killed);
            tried.cut(&steps[..at], &mut loss)
        }
        _ => {
            let first = tried.cut(&tried.steps[..any(&mut random, tried.steps.len())], &mut loss);
            let mut disk = Disk::of(first.path());
            let journal = Journal::of(first.path());
            tried.goes_on(first.path())?;
            let steps = journal.steps();
            steps[..any(&mut random, steps.len())].iter().for_each(|step| disk.step(step));
            let second = folder();
            disk.cut(&mut loss, second.path());
            second
        }
    };
    tried.survives(left.path())
}

/// The model bites: a sync that is left out is found.
#[test]
fn without_a_sync_a_cut_costs_bytes() {
    let tried = Tried::new();
    let failures = |is_left_out: &dyn Fn(&Step) -> bool| -> Vec<String> {
        let steps: Vec<Step> = tried.steps.iter().filter(|step| !is_left_out(step)).cloned().collect();
        // The first steps take the folder: a few tries are theirs.
        let last = |seed: u64| if seed.is_multiple_of(6) { steps.len().min(20) } else { steps.len() };
        let tries = (0..120_u64).map(|seed| (SmallRng::seed_from_u64(seed).random_range(0..=last(seed)), seed));
        let left = tries.map(|(at, seed)| tried.cut(&steps[..at], &mut Loss::seeded(seed)));
        left.filter_map(|left| tried.survives(left.path()).err()).collect()
    };
    let found = failures(&|step| matches!(step, Step::SyncFile(_)));
    assert!(found.iter().any(|why| why.contains("a torn file is believed")), "{found:?}");
    assert!(found.iter().any(|why| why.contains("gonio-run that is no mark")), "{found:?}");
    let found = failures(&|step| matches!(step, Step::SyncFolder(_)));
    assert!(found.iter().any(|why| why.contains("a unit has a record and is not done")), "{found:?}");
    assert!(failures(&|_| false).is_empty());
}

fn name_of(step: &Step) -> String {
    match step {
        Step::Write(path, at, bytes) => format!("Write({path:?}, {at}, {} bytes)", bytes.len()),
        step => format!("{step:?}"),
    }
}
