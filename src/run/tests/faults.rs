//! Kills, refusals, torn writes, cut files and flipped bits.

use std::io::ErrorKind;
use std::sync::Arc;

use super::{outputs, put, run_here, scene, steps};
use crate::base::PhaseName;
use crate::disk::faulty::{Fault, FaultyStore};
use crate::disk::{Ledger, MemStore, Store};
use crate::phases::REPORT;
use crate::pipeline::Pipeline;

fn has_all(store: &MemStore) -> bool {
    let (ledger, _) = Ledger::read(Arc::new(store.clone())).unwrap();
    let units = PhaseName::ALL.iter().flat_map(|phase| ledger.of_phase(*phase));
    units.map(|unit| ledger.files(&unit).unwrap()).all(|files| files.iter().all(|file| file.verify(store).is_ok()))
}

#[test]
fn whatever_fails_at_whatever_step_the_same_bytes_come_out() {
    let (_dir, pipeline) = scene();
    let whole = MemStore::new();
    let counted = FaultyStore::new(Arc::new(whole.clone()), u64::MAX, Fault::Killed);
    run_here(Arc::new(counted.clone()), &pipeline).unwrap();
    let expected = outputs(&whole);
    assert!(counted.steps() > 100, "{} steps", counted.steps());
    for (nth, fault) in [Fault::Refused(ErrorKind::StorageFull), Fault::Killed, Fault::Torn].into_iter().enumerate() {
        for at in steps(nth, counted.steps(), 3) {
            let store = MemStore::new();
            let broken = run_here(Arc::new(FaultyStore::new(Arc::new(store.clone()), at, fault)), &pipeline);
            let why = broken.expect_err("the fault was passed over").to_string();
            if fault == Fault::Refused(ErrorKind::StorageFull) {
                assert!(why.contains("is full, and about"), "step {at}: {why}");
            }
            let (_, notes) = run_here(Arc::new(store.clone()), &pipeline).unwrap();
            assert_eq!(notes, [""; 0], "{fault:?} at step {at}");
            assert!(outputs(&store) == expected && has_all(&store), "{fault:?} at step {at}");
        }
    }
}

#[test]
fn a_corrupt_file_is_set_aside_and_only_its_unit_is_done_again() {
    let (_dir, mut pipeline) = scene();
    pipeline.run.verify = true;
    let whole = MemStore::new();
    run_here(Arc::new(whole.clone()), &pipeline).unwrap();
    // Shards are read again when the tables are made over, the rest by every run.
    let mut unfilled = pipeline.clone();
    unfilled.merge.fill = false;
    let fresh = MemStore::new();
    run_here(Arc::new(fresh.clone()), &unfilled).unwrap();
    let names: Vec<String> = whole.list("").unwrap().into_iter().filter(|name| name != REPORT).collect();
    assert!(names.len() > 12, "{names:?}");
    for name in &names {
        let bytes = whole.open(name).unwrap().to_vec();
        let (again, expected) = if name.ends_with(".rows") { (&unfilled, &fresh) } else { (&pipeline, &whole) };
        for (what, mangled) in [("cut", bytes[..bytes.len() - 2].to_vec()), ("flipped", flipped(&bytes))] {
            let store = copy_of(&whole);
            put(&store, name, &mangled);
            let (report, notes) = run_here(Arc::new(store.clone()), again).unwrap();
            let said = notes.join("\n");
            assert!(said.contains(name.rsplit('/').next().unwrap()), "{what} {name}: {said}");
            let redone = (report.frames.cast, report.shards.inferred);
            let own = match name.split(['/', '-', '.']).next() {
                Some("segments") => (2, 0),
                Some("shards") => (0, 1),
                Some("units") if name.starts_with("units/cast-") => (2, 0),
                Some("units") if name.starts_with("units/infer-") => (0, 1),
                _ => (0, 0),
            };
            assert_eq!(redone, own, "{what} {name}");
            assert!(outputs(&store) == outputs(expected), "{what} {name}");
        }
    }
}

#[test]
fn a_corrupt_block_is_found_when_it_is_needed() {
    let (_dir, pipeline) = scene();
    let store = MemStore::new();
    run_here(Arc::new(store.clone()), &pipeline).unwrap();
    let segment = store.list("segments").unwrap().into_iter().find(|name| name.ends_with(".seg")).unwrap();
    put(&store, &segment, &flipped(&store.open(&segment).unwrap()));
    let mut other: Pipeline = pipeline.clone();
    other.infer.min_bins = 2;
    let (report, notes) = run_here(Arc::new(store.clone()), &other).unwrap();
    assert!(notes.iter().any(|note| note.contains("is done over") && note.contains("checksum")), "{notes:?}");
    assert_eq!((report.frames.cast, report.frames.resumed), (2, 2));
    let kept = format!("corrupt/{}", segment.strip_prefix("segments/").unwrap());
    assert!(store.size(&kept).unwrap().is_some());
    let fresh = MemStore::new();
    run_here(Arc::new(fresh.clone()), &other).unwrap();
    assert!(outputs(&store) == outputs(&fresh));
}

#[test]
fn a_disk_that_spoils_the_same_file_twice_ends_the_run() {
    let (_dir, pipeline) = scene();
    let store = MemStore::new();
    run_here(Arc::new(store.clone()), &pipeline).unwrap();
    let list = store.list("segments").unwrap().into_iter().find(|name| name.ends_with(".blocks")).unwrap();
    let rotten = FaultyStore::rotten(Arc::new(store), &list);
    let why = run_here(Arc::new(rotten), &pipeline).unwrap_err().to_string();
    assert!(why.contains("checksum"), "{why}");
}

#[test]
fn a_disk_without_room_is_refused_before_anything_is_written() {
    let (_dir, pipeline) = scene();
    let store = MemStore::new();
    let narrow = FaultyStore::narrow(Arc::new(store.clone()), 1000);
    let why = run_here(Arc::new(narrow), &pipeline).unwrap_err().to_string();
    assert!(why.contains("too small: about") && why.contains("1000 B are free"), "{why}");
    assert_eq!(store.list("").unwrap(), [""; 0]);
    // What is done takes no more room.
    let (whole, _) = run_here(Arc::new(store.clone()), &pipeline).unwrap();
    let (again, _) = run_here(Arc::new(FaultyStore::narrow(Arc::new(store), 1000)), &pipeline).unwrap();
    assert_eq!((whole.frames.cast, again.frames.cast), (4, 0));
}

/// The same bytes but for a bit in the middle.
fn flipped(bytes: &[u8]) -> Vec<u8> {
    let mut bytes = bytes.to_vec();
    let middle = bytes.len() / 3;
    bytes[middle] ^= 4;
    bytes
}

pub(super) fn copy_of(store: &MemStore) -> MemStore {
    let copy = MemStore::new();
    store.list("").unwrap().iter().for_each(|name| put(&copy, name, &store.open(name).unwrap()));
    copy
}
