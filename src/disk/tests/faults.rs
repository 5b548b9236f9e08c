//! A fault at every single step of the disk, refused, killed and torn: afterwards a unit is done whole or not at all,
//! the other units are as they were, and nothing is left that no record names.

use std::io::{ErrorKind, Write};
use std::sync::Arc;

use super::ledger::{build, cast, open, two_units, units};
use super::mangle;
use crate::base::{Error, Result};
use crate::disk::faulty::{Fault, FaultyStore};
use crate::disk::frozen::Frozen;
use crate::disk::unit_record::file_of;
use crate::disk::{DirStore, Ledger, MemStore, Store};

const FAULTS: [Fault; 3] = [Fault::Refused(ErrorKind::StorageFull), Fault::Killed, Fault::Torn];

/// Runs `work` on a fresh run of two units, once with a fault at each of its steps, and checks what that left. Gives the
/// number of steps.
fn at_each_step(
    fresh: impl Fn() -> Arc<dyn Store>,
    work: impl Fn(&Arc<dyn Store>) -> Result<()>,
    check: impl Fn(&Arc<dyn Store>, &Ledger, bool),
) -> u64 {
    let mut steps = 0;
    for fault in FAULTS {
        for at in 0.. {
            let inner = fresh();
            two_units(&inner);
            let faulty = Arc::new(FaultyStore::new(Arc::clone(&inner), at, fault));
            let store: Arc<dyn Store> = Arc::clone(&faulty) as _;
            let result = work(&store);
            let done = faulty.steps() <= at;
            assert_eq!(result.is_ok(), done, "{fault:?} at step {at}: {result:?}");
            let (ledger, findings, _) = open(&inner);
            assert!(findings.is_empty(), "{fault:?} at step {at}: {findings:?}");
            check(&inner, &ledger, done);
            let named: Vec<_> = units(&ledger).into_iter().flat_map(|(_, files)| files).collect();
            let present = inner.list("segments").unwrap();
            assert!(present.iter().all(|name| named.contains(name)), "{fault:?} at step {at}: {present:?}");
            assert!(open(&inner).1.is_empty() && inner.sweep().unwrap().is_empty());
            if done {
                steps = at;
                break;
            }
        }
    }
    steps
}

fn memory() -> Arc<dyn Store> {
    Arc::new(MemStore::new())
}

fn commit(store: &Arc<dyn Store>) -> Result<()> {
    let ledger = Ledger::read(Arc::clone(store))?.0;
    let mut draft = store.create("segments/c.none-1.seg")?;
    draft.write_all(b"c").map_err(Error::io("write", "c"))?;
    let file = draft.commit()?;
    let committed = ledger.commit(&cast(2), vec![file]);
    assert!(committed.is_err() || ledger.is_done(&cast(2).unit()));
    committed.map(drop)
}

#[test]
fn a_commit_is_whole_or_not_there() {
    let check = |_: &Arc<dyn Store>, ledger: &Ledger, done: bool| {
        assert!(ledger.is_done(&build().unit()) && ledger.is_done(&cast(1).unit()));
        assert!(!done || ledger.is_done(&cast(2).unit()));
        // And the same again.
        ledger.commit(&cast(2), vec![]).unwrap();
        assert_eq!(ledger.len(), 3);
    };
    // Two files: a write, a sync, a naming and a sync of the folder each.
    assert_eq!(at_each_step(memory, commit, check), 8);
    let folder = tempfile::tempdir().unwrap();
    let number = std::cell::Cell::new(0);
    let on_disk = || -> Arc<dyn Store> {
        number.set(number.get() + 1);
        Arc::new(DirStore::new(folder.path().join(number.get().to_string())))
    };
    assert_eq!(at_each_step(on_disk, commit, check), 8);
}

#[test]
fn a_unit_is_forgotten_whole_or_not_at_all() {
    let forget = |store: &Arc<dyn Store>| {
        let ledger = Ledger::read(Arc::clone(store))?.0;
        ledger.forget([cast(1).unit()])
    };
    let check = |_: &Arc<dyn Store>, ledger: &Ledger, done: bool| {
        assert!(ledger.is_done(&build().unit()));
        assert!(!done || !ledger.is_done(&cast(1).unit()));
    };
    // The record, the sync of its folder, two files.
    assert_eq!(at_each_step(memory, forget, check), 4);
}

#[test]
fn a_unit_is_set_aside_whole_or_not_at_all() {
    let set_aside = |store: &Arc<dyn Store>| {
        let ledger = Ledger::read(Arc::clone(store))?.0;
        ledger.set_aside(&store.path("segments/a.none-1.seg")).map(drop)
    };
    let check = |store: &Arc<dyn Store>, ledger: &Ledger, done: bool| {
        assert!(ledger.is_done(&build().unit()));
        assert_eq!(done && !ledger.is_done(&cast(1).unit()), done);
        assert!(!done || store.size("corrupt/a.none-1.seg").unwrap().is_some());
    };
    assert_eq!(at_each_step(memory, set_aside, check), 4);
}

#[test]
fn mending_may_stop_at_any_step_and_is_mended() {
    for fault in FAULTS {
        for at in 0.. {
            let inner = memory();
            two_units(&inner).commit(&cast(2), vec![]).unwrap();
            mangle(&*inner, &file_of(&cast(2).unit()), b"{");
            inner.remove("segments/a.none-1.seg").unwrap();
            let faulty = Arc::new(FaultyStore::new(Arc::clone(&inner), at, fault));
            let opened = Ledger::open(Arc::clone(&faulty) as _);
            let done = faulty.steps() <= at;
            assert_eq!(opened.is_ok(), done, "{fault:?} at step {at}");
            let (ledger, _, _) = open(&inner);
            assert_eq!(
                units(&ledger),
                [(build().unit(), vec!["scene.none-1.cache".to_owned()])],
                "{fault:?} at step {at}"
            );
            assert!(inner.list("segments").unwrap().is_empty());
            assert!(open(&inner).1.is_empty());
            if done {
                // Two records, the sync of their folder, one file.
                assert_eq!(at, 4);
                break;
            }
        }
    }
}

#[test]
fn a_page_is_whole_or_not_there() {
    let pages = |store: &Arc<dyn Store>| Frozen::<u32>::open(Arc::clone(store), "groups").unwrap();
    for fault in FAULTS {
        for at in 0.. {
            let inner = memory();
            pages(&inner).0.add(vec![1, 2]).unwrap();
            let faulty = Arc::new(FaultyStore::new(Arc::clone(&inner), at, fault));
            let added = pages(&(Arc::clone(&faulty) as _)).0.add(vec![3]);
            let (mut list, damage) = pages(&inner);
            assert_eq!(damage, None, "{fault:?} at step {at}");
            assert!(list.items() == [1, 2] || list.items() == [1, 2, 3], "{fault:?} at step {at}");
            if list.items().len() == 2 {
                assert!(added.is_err());
                list.add(vec![3]).unwrap();
            }
            assert_eq!(pages(&inner).0.items(), [1, 2, 3]);
            if faulty.steps() <= at {
                assert!(added.is_ok() && at == 4);
                break;
            }
        }
    }
}

#[test]
fn setting_pages_aside_may_stop_at_any_step() {
    let pages = |store: Arc<dyn Store>| Frozen::<u32>::open(store, "groups");
    for fault in FAULTS {
        for at in 0.. {
            let inner = memory();
            let mut list = pages(Arc::clone(&inner)).unwrap().0;
            for n in 1..5 {
                list.add(vec![n]).unwrap();
            }
            mangle(&*inner, "groups/000001.json", b"{");
            let faulty = Arc::new(FaultyStore::new(Arc::clone(&inner), at, fault));
            let opened = pages(Arc::clone(&faulty) as _);
            let (list, _) = pages(Arc::clone(&inner)).unwrap();
            assert_eq!(list.items(), [1], "{fault:?} at step {at}");
            assert_eq!(inner.list("groups").unwrap(), ["groups/000000.json"], "{fault:?} at step {at}");
            assert_eq!(pages(Arc::clone(&inner)).unwrap().1, None);
            if faulty.steps() <= at {
                assert!(opened.is_ok() && at == 4, "three pages and the sync of their folder, not {at}");
                break;
            }
            assert!(opened.is_err());
        }
    }
}
