//! Input files that fail, change, come and go while they are read: whatever happened in the run before, the next run gives
//! what the files hold, and what may pass costs no frame.
//!
//! `GONIO_INPUT_FAULTS=N` tries N schedules of several faults instead of a few; `GONIO_INPUT_FAULT=SEED` replays one.

use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};
use rustix::io::Errno;
use tempfile::TempDir;

use super::faults::copy_of;
use super::{outputs, run_here, scene, seeds, steps};
use crate::base::faulty_input::{Fault, FaultyInput};
use crate::codec::meshes::{self, ply};
use crate::disk::MemStore;
use crate::phases::Report;
use crate::pipeline::load;
use crate::scene::Mesh;

/// Errors that may pass, and reads that give less than was asked for.
const PASSING: [Fault; 5] = [
    Fault::Short,
    Fault::Refused(Errno::INTR.raw_os_error()),
    Fault::Refused(Errno::NOENT.raw_os_error()),
    Fault::Refused(Errno::STALE.raw_os_error()),
    Fault::Refused(Errno::IO.raw_os_error()),
];

/// Files that change.
const CHANGES: [Fault; 5] = [Fault::Cut, Fault::Grown, Fault::Exchanged, Fault::Overwritten, Fault::Gone];

/// Schedules of several faults that are tried unless more are asked for.
const FEW: u64 = 100;

/// All files below a folder.
fn files(folder: &Path) -> Files {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        if entry.file_type().unwrap().is_dir() {
            found.extend(
                files(&entry.path())
                    .into_iter()
                    .map(|(below, bytes)| (PathBuf::from(entry.file_name()).join(below), bytes)),
            );
        } else {
            found.insert(entry.file_name().into(), fs::read(entry.path()).unwrap());
        }
    }
    found
}

/// Input files by their names.
type Files = BTreeMap<PathBuf, Vec<u8>>;

/// What a run gives: its outputs, or why there are none.
type Given = Result<Vec<Vec<u8>>, String>;

/// A scene with a mask, and how often its files are opened and read.
struct Tried {
    files: Files,
    calls: u64,
    /// What these files give in a run without faults.
    given: RefCell<BTreeMap<Files, Given>>,
}

impl Tried {
    fn new() -> Self {
        let (dir, _) = scene();
        thin(&dir.path().join("mesh.ply"));
        fs::create_dir(dir.path().join("masks")).unwrap();
        let mask = image::GrayImage::from_fn(48, 32, |x, _| image::Luma([u8::from(x > 9)]));
        mask.save(dir.path().join("masks/frame_001.jpg.png")).unwrap();
        let text = fs::read_to_string(dir.path().join("p.toml")).unwrap();
        // Exposures and light stay as they were first found. So that all runs give the same, nothing is made of them.
        let text = text.replace("images = ", "masks = \"masks\"\nimages = ");
        let text = text.replace("[infer]", "[decode]\nexposure = \"as_is\"\n[infer]\nestimator = \"network\"");
        fs::write(dir.path().join("p.toml"), text).unwrap();
        let mut tried = Tried { files: files(dir.path()), calls: 0, given: RefCell::default() };
        let folder = tried.folder();
        let counted = FaultyInput::below(folder.path(), Vec::new());
        tried.given(folder.path()).unwrap();
        tried.calls = counted.calls();
        tried
    }

    /// The scene in a folder of its own.
    fn folder(&self) -> TempDir {
        let folder = TempDir::new().unwrap();
        for (name, bytes) in &self.files {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
        folder
    }

    /// What the files in a folder give.
    fn given(&self, folder: &Path) -> Given {
        let store = MemStore::new();
        let fresh = || run(folder, &store).map(|_| outputs(&store));
        self.given.borrow_mut().entry(files(folder)).or_insert_with(fresh).clone()
    }

    /// Runs with these faults, and once more without.
    fn survives(&self, faults: &[(u64, Fault)]) {
        let (folder, store) = (self.folder(), MemStore::new());
        let faulty = FaultyInput::below(folder.path(), faults.to_vec());
        let first = run(folder.path(), &store);
        drop(faulty);
        let expected = self.given(folder.path());
        if faults.len() == 1 && PASSING.contains(&faults[0].1) {
            assert!(first.unwrap().skipped.is_empty(), "{faults:?} cost a frame");
            assert!(Ok(outputs(&store)) == expected, "{faults:?} changed something");
            return;
        }
        // As if nothing had been changed: what was seen meanwhile must not stay under the name of what is there now.
        let (back, copy) = (self.folder(), copy_of(&store));
        assert!(run(back.path(), &copy).unwrap().skipped.is_empty(), "{faults:?} cost a frame for good");
        assert!(Ok(outputs(&copy)) == self.given(back.path()), "{faults:?} stayed");
        let next = run(folder.path(), &store);
        if files(folder.path()) == self.files {
            assert!(next.as_ref().unwrap().skipped.is_empty(), "{faults:?}: {next:?}");
        }
        let next = next.map(|_| outputs(&store));
        assert!(next == expected, "{faults:?}: {:?}, but {:?}", next.map(drop), expected.map(drop));
    }
}

/// Leaves one triangle in sixteen: thousands of runs must not take long.
pub(super) fn thin(path: &Path) {
    let Mesh { origin, positions, triangles } = meshes::read(path, &|_| Ok(())).unwrap();
    let triangles: Vec<[u32; 3]> = triangles.iter().copied().step_by(16).collect();
    let mut bytes = Vec::new();
    ply::write_mesh(&mut bytes, &Mesh { origin, positions, triangles: triangles.into() }, &[]).unwrap();
    fs::write(path, bytes).unwrap();
}

fn run(folder: &Path, store: &MemStore) -> Result<Report, String> {
    let pipeline = load(&folder.join("p.toml"), &[]).map_err(|_| "the pipeline file is refused".to_owned())?;
    let named = |why: crate::base::Error| why.to_string().replace(&*folder.to_string_lossy(), "");
    run_here(Arc::new(store.clone()), &pipeline).map(|(report, _)| report).map_err(named)
}

#[test]
fn a_fault_at_any_call_on_an_input_costs_nothing_that_stays() {
    let tried = Tried::new();
    assert!(tried.calls > 40, "{} calls", tried.calls);
    for (nth, fault) in PASSING.into_iter().chain(CHANGES).enumerate() {
        steps(nth, tried.calls, 4).for_each(|at| tried.survives(&[(at, fault)]));
    }
    // What lasts longer than patience costs a frame, until the next run.
    for (nth, errno) in [Errno::NOENT, Errno::IO].into_iter().enumerate() {
        let lasting = |at| (at..at + 4).map(|at| (at, Fault::Refused(errno.raw_os_error()))).collect::<Vec<_>>();
        steps(nth, tried.calls, 2).for_each(|at| tried.survives(&lasting(at)));
    }
}

#[test]
fn schedules_of_faults_cost_nothing_that_stays() {
    let tried = Tried::new();
    for seed in seeds("GONIO_INPUT_FAULT", "GONIO_INPUT_FAULTS", FEW) {
        let mut random = SmallRng::seed_from_u64(seed);
        let all: Vec<Fault> = PASSING.into_iter().chain(CHANGES).collect();
        let faults: Vec<(u64, Fault)> = (0..random.random_range(2..6))
            .map(|_| (random.random_range(0..tried.calls), all[random.random_range(0..all.len())]))
            .collect();
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| tried.survives(&faults)));
        assert!(
            done.is_ok(),
            "schedule {seed}, {faults:?}: replay it with\n  GONIO_INPUT_FAULT={seed} cargo test --lib schedules_of_faults_cost"
        );
    }
}
