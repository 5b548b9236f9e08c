//! Rot of every kind in every file that a run leaves: `verify` names it, and the next run makes the same bytes again.

use std::collections::BTreeMap;
use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::sync::Arc;

use super::{run_here, scene};
use crate::base::Result;
use crate::disk::lock::LOCK;
use crate::disk::mark::MARK;
use crate::disk::{DirStore, Lock, Store};
use crate::phases::{Cause, PHASES, REPORT};
use crate::pipeline::Pipeline;
use crate::run::verify::{Verified, verify_phases};
use crate::stages::infer::Method;
use crate::stages::light::Mode;

/// What may happen to a file.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Rot {
    Flipped,
    Cut,
    Grown,
    Missing,
    Folder,
    Link,
}

const ROTS: [Rot; 6] = [Rot::Flipped, Rot::Cut, Rot::Grown, Rot::Missing, Rot::Folder, Rot::Link];

impl Rot {
    /// Lets a file rot; `aside` is where a link leads, to the file as it was.
    fn strike(self, file: &Path, aside: &Path) {
        let mut bytes = fs::read(file).unwrap();
        // A new file: other folders have links to the old one.
        fs::remove_file(file).unwrap();
        match self {
            Rot::Missing => return,
            Rot::Folder => {
                fs::create_dir(file).unwrap();
                return fs::write(file.join("within"), "somebody's").unwrap();
            }
            Rot::Link => {
                fs::write(aside, bytes).unwrap();
                return symlink(aside, file).unwrap();
            }
            Rot::Flipped => {
                let middle = bytes.len() / 3;
                bytes[middle] ^= 4;
            }
            Rot::Cut => bytes.truncate(bytes.len() - 2),
            Rot::Grown => bytes.push(0),
        }
        fs::write(file, bytes).unwrap();
    }
}

fn ran(pipeline: &Pipeline, work: &Path) -> Vec<String> {
    let store = DirStore::new(work);
    let _lock = Lock::acquire(&store).unwrap();
    run_here(Arc::new(store), pipeline).unwrap().1
}

fn verified(pipeline: &Pipeline, work: &Path, inputs: bool) -> Result<Verified> {
    let store: Arc<dyn Store> = Arc::new(DirStore::new(work));
    verify_phases(PHASES, &store, pipeline, inputs)
}

/// The files that a run leaves, by their names without what is another's in every attempt. A unit record holds such names, and a
/// report holds times, so of these the names alone count.
fn left(work: &Path) -> BTreeMap<String, Vec<u8>> {
    let store = DirStore::new(work);
    let names = store.list("").unwrap().into_iter().filter(|name| ![MARK, LOCK].contains(&&**name));
    let names = names.filter(|name| !name.starts_with("corrupt/"));
    let kept = |name: String| {
        let bytes = if name.starts_with("units/") || name == REPORT { vec![] } else { store.read(&name).unwrap() };
        let (start, end) = (name.split('.').next().unwrap(), name.rsplit('.').next().unwrap());
        (format!("{start}.{end}"), bytes)
    };
    names.map(kept).collect()
}

/// A copy of a folder; files are the same until one is replaced.
fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target)
        } else {
            drop(fs::hard_link(entry.path(), target))
        }
    }
}

#[test]
fn rot_of_any_kind_in_any_file_is_named_and_made_again() {
    let (dir, mut pipeline) = scene();
    pipeline.run.verify = true;
    let (whole, work, aside) = (dir.path().join("whole"), dir.path().join("rotten"), dir.path().join("aside"));
    ran(&pipeline, &whole);
    let (expected, names) = (left(&whole), DirStore::new(&whole).list("").unwrap());
    let names: Vec<String> = names.into_iter().filter(|name| ![MARK, LOCK].contains(&&**name)).collect();
    assert!(names.len() > 15, "{names:?}");
    for (name, rot) in names.iter().flat_map(|name| ROTS.map(|rot| (name, rot))) {
        copy(&whole, &work);
        let original = fs::read(work.join(name)).unwrap();
        rot.strike(&work.join(name), &aside);
        let found = verified(&pipeline, &work, false).unwrap();
        if name == REPORT && rot == Rot::Missing {
            // As a run leaves it that was killed at its very end.
            assert!(found.is_sound() && !found.finished);
        } else {
            // A record that is gone is known by the number of those that are left.
            let at = if name.starts_with("units/") && rot == Rot::Missing { "units" } else { name };
            assert!(found.held.rotten.iter().any(|rotten| rotten.file == at), "{rot:?} {name}: {found:?}");
        }
        let notes = ran(&pipeline, &work);
        assert!(left(&work) == expected, "{rot:?} {name}: {notes:?}");
        let after = verified(&pipeline, &work, true).unwrap();
        assert!(after.is_sound() && after.finished, "{rot:?} {name}: {after:?}");
        if rot == Rot::Link {
            assert!(fs::read(&aside).unwrap() == original, "{name} was followed");
        }
        if rot == Rot::Folder {
            let kept = work.join("corrupt").join(name.rsplit('/').next().unwrap());
            let groups = work.join("corrupt").join(name.replace('/', "-"));
            assert!(kept.join("within").is_file() || groups.join("within").is_file(), "{name}: {notes:?}");
        }
        fs::remove_dir_all(&work).unwrap();
    }
}

#[test]
fn many_rotten_files_are_made_again_in_one_go() {
    let (dir, mut pipeline) = scene();
    pipeline.run.verify = true;
    let (whole, work) = (dir.path().join("whole"), dir.path().join("rotten"));
    ran(&pipeline, &whole);
    copy(&whole, &work);
    let names = DirStore::new(&work).list("").unwrap();
    let rotten = |name: &&String| [".seg", ".rows", ".npy", ".ply", ".glb"].iter().any(|ending| name.ends_with(ending));
    let names: Vec<&String> = names.iter().filter(rotten).collect();
    names.iter().for_each(|name| Rot::Flipped.strike(&work.join(name), &work));
    assert_eq!(verified(&pipeline, &work, false).unwrap().held.rotten.len(), names.len());
    let notes = ran(&pipeline, &work);
    let done_over = notes.iter().filter(|note| note.contains("is done over"));
    assert_eq!(done_over.count(), names.len() - 1, "both tables are one unit: {notes:?}");
    assert!(left(&work) == left(&whole));
}

#[test]
fn a_run_that_is_not_finished_is_verified_as_far_as_it_is() {
    let (dir, pipeline) = scene();
    let work = dir.path().join("work");
    ran(&pipeline, &work);
    // As if it had been killed before its tables were there.
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&work));
    let (ledger, _) = crate::disk::Ledger::read(Arc::clone(&store)).unwrap();
    fs::remove_file(work.join(REPORT)).unwrap();
    for phase in [crate::base::PhaseName::Export, crate::base::PhaseName::Merge] {
        ledger.forget(ledger.of_phase(phase)).unwrap();
    }
    let found = verified(&pipeline, &work, true).unwrap();
    assert!(found.is_sound() && !found.finished, "{found:?}");
    assert_eq!(found.held.units, 8, "the cache, two groups that were looked at, the light, two groups, two shards");
    let segment = store.list("segments").unwrap().into_iter().find(|name| name.ends_with(".seg")).unwrap();
    Rot::Flipped.strike(&work.join(&segment), &work);
    let found = verified(&pipeline, &work, true).unwrap();
    let [rotten] = &found.held.rotten[..] else { panic!("{found:?}") };
    assert!(rotten.file == segment && rotten.unit.as_deref().is_some_and(|unit| unit.starts_with("cast ")));
    assert!(rotten.why.contains("the file has changed since it was written"), "{rotten:?}");
}

#[test]
fn an_input_that_changed_is_named_with_what_was_made_of_it() {
    let (dir, pipeline) = scene();
    let work = dir.path().join("work");
    ran(&pipeline, &work);
    let changed = |pipeline: &Pipeline| {
        let found = verified(pipeline, &work, true).unwrap();
        assert!(found.held.rotten.is_empty() && verified(pipeline, &work, false).unwrap().is_sound());
        let told =
            found.changed.iter().map(|changed| (changed.input.clone(), changed.unit.clone(), changed.cause.clone()));
        (told.collect::<Vec<_>>(), found.unread.len())
    };
    assert_eq!(changed(&pipeline), (vec![], 0));
    // Other settings are no other inputs.
    let mut other = pipeline.clone();
    (other.infer.estimator, other.light.mode) = (Method::Fit, Mode::Known);
    assert_eq!(changed(&other).0, []);

    let frame = pipeline.scene.images.join("frame_003.jpg");
    let whole = fs::read(&frame).unwrap();
    for rot in [Rot::Flipped, Rot::Cut, Rot::Missing] {
        rot.strike(&frame, &frame);
        let (told, _) = changed(&pipeline);
        let [(input, unit, Cause::Frame { .. })] = &told[..] else { panic!("{rot:?}: {told:?}") };
        assert_eq!((input, unit.as_str()), (&frame, "look 1"), "{rot:?}");
        fs::write(&frame, &whole).unwrap();
    }
    let poses = pipeline.scene.poses.path.join("images.bin");
    let whole = fs::read(&poses).unwrap();
    let mut turned = whole.clone();
    turned[20] ^= 1;
    fs::write(&poses, &turned).unwrap();
    let (told, _) = changed(&pipeline);
    let at_poses = |told: &[(std::path::PathBuf, String, Cause)]| {
        told.iter().all(|(input, ..)| *input == pipeline.scene.poses.path)
    };
    assert!(!told.is_empty() && at_poses(&told), "{told:?}");
    fs::write(&poses, &whole).unwrap();

    let mut mesh = fs::read(pipeline.scene.mesh.first()).unwrap();
    let end = mesh.len();
    mesh[end / 2] ^= 1;
    fs::write(pipeline.scene.mesh.first(), &mesh).unwrap();
    let (told, _) = changed(&pipeline);
    assert!(!told.is_empty() && told.iter().all(|(input, ..)| *input == pipeline.scene.mesh.first()), "{told:?}");
    fs::write(pipeline.scene.mesh.first(), &mesh[..end / 2]).unwrap();
    assert_eq!(changed(&pipeline).1, 1, "a mesh that is cut short cannot be read");
    mesh[end / 2] ^= 1;
    fs::write(pipeline.scene.mesh.first(), &mesh).unwrap();
    assert_eq!(changed(&pipeline), (vec![], 0));
}
