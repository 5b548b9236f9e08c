//! The rules of every store, then the ones that only a folder can break.

use std::collections::BTreeSet;
use std::fs;
use std::io::Write;
use std::sync::Arc;

use super::{mangle, on_each_store, put};
use crate::disk::faulty::{Fault, FaultyStore};
use crate::disk::names::check_name;
use crate::disk::{Committed, DirStore, MemStore, Store};

#[test]
fn what_is_committed_is_read_back() {
    on_each_store(|store| {
        let large: Vec<u8> = (0..1_000_003u32).map(|n| n.to_le_bytes()[0]).collect();
        for (name, bytes) in [("a", &b""[..]), ("b/c.seg", b"xyz"), ("b/d/e", &large)] {
            let entry = put(&*store, name, bytes);
            assert_eq!((entry.name.as_str(), entry.bytes), (name, bytes.len() as u64));
            assert_eq!(entry.checksum.to_string(), blake3::hash(bytes).to_hex().as_str());
            assert_eq!(&*store.open(name).unwrap(), bytes);
            assert_eq!(&*entry.verify(&*store).unwrap(), bytes);
            assert_eq!(store.size(name).unwrap(), Some(bytes.len() as u64));
        }
        assert_eq!(store.list("").unwrap(), ["a", "b/c.seg", "b/d/e"]);
        assert_eq!(store.list("b").unwrap(), ["b/c.seg", "b/d/e"]);
        assert_eq!(store.list("none").unwrap(), [""; 0]);
        assert_eq!(store.size("b").unwrap(), None, "a folder is no file");
    });
}

#[test]
fn a_draft_is_not_there_until_it_is_committed() {
    on_each_store(|store| {
        let mut draft = store.create("a").unwrap();
        draft.write_all(&[7; 300_000]).unwrap();
        draft.flush().unwrap();
        assert_eq!(store.size("a").unwrap(), None);
        assert!(store.list("").unwrap().is_empty() && store.open("a").is_err());
        drop(draft);
        assert_eq!(store.size("a").unwrap(), None);
        assert!(store.sweep().unwrap().is_empty(), "a dropped draft leaves nothing");
    });
}

#[test]
fn files_are_written_once_or_replaced_whole() {
    on_each_store(|store| {
        put(&*store, "a", b"first");
        let mut second = store.create("a").unwrap();
        second.write_all(b"second").unwrap();
        let why = second.commit().unwrap_err().to_string();
        assert!(why.contains("the file exists, and is written only once"), "{why}");
        let old = store.open("a").unwrap();
        assert_eq!(&*old, b"first");
        mangle(&*store, "a", b"third");
        assert_eq!((&*store.open("a").unwrap(), &*old), (&b"third"[..], &b"first"[..]));
        store.remove("a").unwrap();
        assert_eq!(&*old, b"first", "open bytes outlive the file");
        assert!(store.remove("a").unwrap_err().to_string().starts_with("cannot remove "));
        assert!(store.open("a").unwrap_err().to_string().starts_with("cannot open "));
    });
}

#[test]
fn two_drafts_of_one_name_do_not_mix() {
    on_each_store(|store| {
        let (mut a, mut b) = (store.create("x").unwrap(), store.create("x").unwrap());
        a.write_all(b"aaaa").unwrap();
        b.write_all(b"b").unwrap();
        a.commit().unwrap();
        assert!(b.commit().is_err());
        assert_eq!(&*store.open("x").unwrap(), b"aaaa");
    });
}

#[test]
fn the_first_of_two_files_keeps_the_name() {
    on_each_store(|store| {
        let (mut first, mut second) = (store.create("d/x").unwrap(), store.create("d/x").unwrap());
        first.write_all(b"first").unwrap();
        second.write_all(b"second!").unwrap();
        let (entry, committed) = first.commit_first().unwrap();
        assert_eq!((entry.bytes, committed), (5, Committed::Now));
        let (entry, committed) = second.commit_first().unwrap();
        assert_eq!((entry.bytes, committed), (7, Committed::Already));
        assert_eq!(&*store.open("d/x").unwrap(), b"first");
        assert_eq!(store.read("d/x").unwrap(), b"first");
        store.sync("d").unwrap();
        store.sync("none").unwrap();
        assert!(store.sweep().unwrap().is_empty(), "no temporary file is left");
    });
}

#[test]
fn one_of_many_threads_gets_a_name() {
    on_each_store(|store| {
        for round in 0..20 {
            let name = format!("x{round}");
            let drafts: Vec<_> = (0..4).map(|_| store.create(&name).unwrap()).collect();
            let won = std::thread::scope(|scope| {
                let threads: Vec<_> = drafts.into_iter().map(|draft| scope.spawn(|| draft.commit().is_ok())).collect();
                threads.into_iter().map(|thread| thread.join().unwrap()).filter(|won| *won).count()
            });
            assert_eq!(won, 1);
        }
    });
}

#[test]
fn an_attempt_is_short_and_fresh_and_shared_by_clones() {
    let stores: Vec<DirStore> = (0..100).map(|_| DirStore::new("x")).collect();
    let attempts: BTreeSet<&str> = stores.iter().map(Store::attempt).collect();
    assert_eq!(attempts.len(), 100);
    assert!(attempts.iter().all(|attempt| attempt.len() == 21 && check_name(attempt).is_ok()), "{attempts:?}");
    assert_eq!(stores[0].clone().attempt(), stores[0].attempt());
    let memory: Arc<dyn Store> = Arc::new(MemStore::new());
    assert_eq!(FaultyStore::new(Arc::clone(&memory), 0, Fault::Killed).attempt(), "none-memory");
}

#[test]
fn names_stay_inside() {
    let long = "n".repeat(201);
    let bad =
        ["", "/", "/etc/passwd", "..", "../a", "a/../../b", "a//b", "a/", "./a", ".", "a\\b", "a\0b", "c:x", "a\n"];
    for name in bad.into_iter().chain(["x.gonio-tmp", &long]) {
        assert!(check_name(name).is_err(), "{name:?}");
        on_each_store(|store| {
            assert!(store.create(name).is_err() && store.open(name).is_err() && store.remove(name).is_err());
            assert!(store.size(name).is_err() && (name.is_empty() || store.list(name).is_err()), "{name:?}");
        });
    }
    for name in ["a", "a.b", "..a", "segments/0001.seg", ".hidden", "ünï cöde"] {
        assert!(check_name(name).is_ok(), "{name:?}");
    }
}

#[test]
fn a_changed_file_is_found_out_by_its_entry() {
    on_each_store(|store| {
        let entry = put(&*store, "a", b"abc");
        for other in [&b"abd"[..], b"ab", b"abcd", b""] {
            mangle(&*store, "a", other);
            let why = entry.verify(&*store).unwrap_err().to_string();
            assert!(why.contains("the file has changed since it was written"), "{why}");
        }
    });
}

#[test]
fn threads_may_write_at_once() {
    on_each_store(|store| {
        std::thread::scope(|scope| {
            for t in 0..4u8 {
                let store = &store;
                scope.spawn(move || (0..8).for_each(|n| drop(put(&**store, &format!("d{n}/{t}"), &[t; 100]))));
            }
        });
        assert_eq!(store.list("").unwrap().len(), 32);
    });
}

#[test]
fn a_folder_is_swept_of_temporary_files_alone() {
    let folder = tempfile::tempdir().unwrap();
    let store = DirStore::new(folder.path());
    put(&store, "segments/a.seg", b"a");
    fs::write(folder.path().join("photo.jpg"), "mine").unwrap();
    fs::write(folder.path().join("segments/b.seg.none-77-3.gonio-tmp"), "torn").unwrap();
    let others = ["x.gonio-tmp", "x.7-3.gonio-tmp", "segments/b.seg.0123456789abcdef-7-3.gonio-tmp"];
    others.iter().for_each(|name| fs::write(folder.path().join(name), "of another run").unwrap());
    assert_eq!(store.list("").unwrap(), ["photo.jpg", "segments/a.seg"]);
    assert_eq!(store.sweep().unwrap(), ["segments/b.seg.none-77-3.gonio-tmp"]);
    assert!(store.sweep().unwrap().is_empty());
    assert!(others.iter().all(|name| folder.path().join(name).exists()));
    assert_eq!(store.list("").unwrap(), ["photo.jpg", "segments/a.seg"]);
}

#[test]
fn scratch_is_written_then_changed_and_leaves_nothing() {
    on_each_store(|store| {
        let mut scratch = store.scratch().unwrap();
        (0..100_000u32).for_each(|n| scratch.write_all(&n.to_le_bytes()).unwrap());
        let mut working = scratch.work().unwrap();
        let values = working.values::<u32>().unwrap();
        assert!(values.iter().copied().eq(0..100_000));
        values[7] = 9;
        assert_eq!((working[28], working[32], working.len()), (9, 8, 400_000));
        assert!(working.values::<[u32; 3]>().is_err(), "no whole number of them");
        assert!(store.list("").unwrap().is_empty());
        drop(working);
        assert!(store.sweep().unwrap().is_empty());
    });
}

#[test]
fn scratch_of_a_killed_process_is_swept() {
    let folder = tempfile::tempdir().unwrap();
    let store = DirStore::new(folder.path());
    let mut scratch = store.scratch().unwrap();
    scratch.write_all(&[1; 10]).unwrap();
    std::mem::forget(scratch.work().unwrap());
    assert_eq!(store.sweep().unwrap().len(), 1);
    assert!(fs::read_dir(folder.path()).unwrap().next().is_none());
}
