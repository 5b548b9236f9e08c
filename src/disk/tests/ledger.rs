//! The ledger: what a record names survives, what no record names goes, and a corrupt record costs its own unit alone.

use std::collections::BTreeSet;
use std::sync::Arc;

use super::{mangle, on_each_store, put};
use crate::base::PhaseName;
use crate::base::key::Key;
use crate::disk::Recipe;
use crate::disk::unit_record::{UnitRecord, file_of};
use crate::disk::{Committed, FileEntry, Findings, Ledger, MemStore, Store, UnitName};

/// Opens the ledger as a run does, and sweeps: what was found, and the names of what was swept.
pub(super) fn open(store: &Arc<dyn Store>) -> (Ledger, Findings, Vec<String>) {
    let (ledger, findings) = Ledger::open(Arc::clone(store)).unwrap();
    let swept = ledger.sweep().unwrap();
    (ledger, findings, swept)
}

pub(super) fn cast(number: u32) -> Recipe {
    Recipe::new(PhaseName::Cast, number.to_string()).with("number", number)
}

pub(super) fn build() -> Recipe {
    Recipe::new(PhaseName::Build, "").with("mesh", "abc")
}

/// A run with two units and three files.
pub(super) fn two_units(store: &Arc<dyn Store>) -> Ledger {
    let (ledger, findings, _) = open(store);
    assert!(findings.is_empty() && ledger.is_empty());
    let files = vec![put(&**store, "segments/a.none-1.seg", b"aa"), put(&**store, "segments/b.none-1.seg", b"")];
    assert_eq!(ledger.commit(&cast(1), files).unwrap(), Committed::Now);
    let files = vec![put(&**store, "scene.none-1.cache", b"cache")];
    assert_eq!(ledger.commit(&build(), files).unwrap(), Committed::Now);
    ledger
}

/// All units that are done, with the names of their files.
pub(super) fn units(ledger: &Ledger) -> Vec<(UnitName, Vec<String>)> {
    let phases = PhaseName::ALL.into_iter().chain([PhaseName::Mock]);
    let all: Vec<_> = phases.flat_map(|phase| ledger.of_phase(phase)).collect();
    assert_eq!(all.len(), ledger.len());
    let names = |unit: &UnitName| ledger.files(unit).unwrap().iter().map(|file| file.name.clone()).collect();
    all.into_iter().map(|unit| (unit, names(&unit))).collect()
}

fn record(recipe: &Recipe) -> String {
    file_of(&recipe.unit())
}

fn why(findings: &[crate::disk::Finding]) -> Vec<(UnitName, &str)> {
    findings.iter().map(|finding| (finding.unit, finding.why.as_str())).collect()
}

#[test]
fn what_is_committed_is_told() {
    on_each_store(|store| {
        let written = two_units(&store);
        assert_eq!(written.commit(&cast(2), vec![]).unwrap(), Committed::Now);
        let again = cast(1).with("other", "x");
        assert_eq!(written.commit(&again, vec![]).unwrap(), Committed::Now);
        let read = Ledger::read(Arc::clone(&store)).unwrap().0;
        for ledger in [written, open(&store).0, read] {
            assert_eq!((ledger.len(), ledger.is_empty()), (4, false));
            assert!(ledger.is_done(&cast(1).unit()) && !ledger.is_done(&cast(3).unit()));
            let files = ledger.files(&cast(1).unit()).unwrap();
            assert_eq!(
                (files[0].name.as_str(), files[0].bytes, files[0].checksum),
                ("segments/a.none-1.seg", 2, Key::of_bytes(b"aa"))
            );
            assert_eq!(files.len(), 2);
            assert!(ledger.files(&cast(3).unit()).is_none());
            assert_eq!(ledger.recipe(&cast(1).unit()).unwrap(), cast(1));
            assert!(ledger.recipe(&cast(3).unit()).is_err());
            assert_eq!(ledger.what(&cast(1).unit()).as_deref(), Some("1"));
            assert_eq!((ledger.what(&build().unit()).as_deref(), ledger.what(&cast(3).unit())), (Some(""), None));
            let set = |names: Vec<UnitName>| {
                assert!(names.is_sorted());
                names.into_iter().collect::<BTreeSet<_>>()
            };
            let casts = [cast(1).unit(), cast(2).unit(), again.unit()];
            assert_eq!(set(ledger.of_phase(PhaseName::Cast)), casts.into());
            assert_eq!(ledger.of_phase(PhaseName::Build), [build().unit()]);
            assert!(ledger.of_phase(PhaseName::Mock).is_empty());
            assert_eq!(set(ledger.find(PhaseName::Cast, "1")), [cast(1).unit(), again.unit()].into());
            assert_eq!(ledger.find(PhaseName::Build, ""), [build().unit()]);
            assert!(ledger.find(PhaseName::Build, "1").is_empty() && ledger.find(PhaseName::Cast, "").is_empty());
        }
    });
}

#[test]
fn what_is_named_survives_and_the_rest_is_swept() {
    on_each_store(|store| {
        let done = units(&two_units(&store));
        for round in 0..10 {
            // As a run leaves it that is killed after its files and before its record.
            put(&*store, "segments/c.none-1.seg", &[round]);
            put(&*store, "segments/deep/d.none-1.seg", b"d");
            let _draft = store.create("segments/e.none-1.seg").unwrap();
            mangle(&*store, "photo.jpg", b"the user's own");
            let (ledger, findings, swept) = open(&store);
            assert_eq!(units(&ledger), done);
            assert!(findings.is_empty());
            let committed = swept.iter().filter(|name| name.ends_with(".seg")).collect::<Vec<_>>();
            assert_eq!(committed, ["segments/c.none-1.seg", "segments/deep/d.none-1.seg"]);
            let (build, cast) = (record(&build()), record(&cast(1)));
            let kept =
                ["photo.jpg", "scene.none-1.cache", "segments/a.none-1.seg", "segments/b.none-1.seg", &build, &cast];
            assert_eq!(store.list("").unwrap(), kept);
        }
    });
}

#[test]
fn only_what_carries_the_runs_id_is_swept() {
    on_each_store(|store| {
        put(&*store, "scene.none-1.cache", b"made, but never named");
        let others =
            ["a.other-1.seg", "corrupt/a.none-1.seg", "export/scene.ply", "segments/a.seg", "segments/none-1.seg"];
        others.iter().for_each(|name| drop(put(&*store, name, b"somebody's")));
        assert_eq!(open(&store).2, ["scene.none-1.cache"]);
        assert_eq!(store.list("").unwrap(), others);
    });
}

#[test]
fn units_with_missing_files_are_lost_and_named() {
    on_each_store(|store| {
        two_units(&store).commit(&cast(2), vec![put(&*store, "segments/c.none-1.seg", b"c")]).unwrap();
        store.remove("segments/b.none-1.seg").unwrap();
        mangle(&*store, "scene.none-1.cache", b"longer than it was");
        let before = store.list("").unwrap();
        let lost = [
            (build().unit(), "scene.none-1.cache has 18 bytes instead of 5"),
            (cast(1).unit(), "segments/b.none-1.seg is not there"),
        ];
        let (read, findings) = Ledger::read(Arc::clone(&store)).unwrap();
        assert_eq!((read.len(), why(&findings.lost)), (1, lost.to_vec()));
        assert_eq!(store.list("").unwrap(), before, "reading changes nothing");

        let (ledger, findings, swept) = open(&store);
        assert_eq!(units(&ledger), [(cast(2).unit(), vec!["segments/c.none-1.seg".to_owned()])]);
        assert_eq!((why(&findings.lost), findings.corrupt.len()), (lost.to_vec(), 0));
        assert_eq!(findings.lost[0].kept.as_deref(), Some("corrupt/scene.none-1.cache"));
        assert_eq!(findings.lost[1].kept, None);
        assert_eq!(&*store.open("corrupt/scene.none-1.cache").unwrap(), b"longer than it was");
        assert_eq!(store.list("").unwrap(), ["corrupt/scene.none-1.cache", "segments/c.none-1.seg", &record(&cast(2))]);
        assert!(swept.is_empty() && open(&store).1.is_empty(), "it is reported once");
    });
}

#[test]
fn every_truncation_and_every_flipped_bit_costs_that_unit_alone() {
    // In memory alone: thousands of files, each synced, take a disk minutes.
    let store: Arc<dyn Store> = Arc::new(MemStore::new());
    two_units(&store);
    let name = record(&cast(1));
    let whole = store.open(&name).unwrap().to_vec();
    let check = |bytes: &[u8], what: String| {
        mangle(&*store, &name, bytes);
        let (ledger, findings) = Ledger::read(Arc::clone(&store)).unwrap();
        assert_eq!(units(&ledger), [(build().unit(), vec!["scene.none-1.cache".to_owned()])], "{what}");
        let found = findings.corrupt.iter().map(|finding| finding.unit).collect::<Vec<_>>();
        assert_eq!((found, findings.lost.len()), (vec![cast(1).unit()], 0), "{what}");
        assert!(ledger.recipe(&cast(1).unit()).unwrap_err().malformed_file().is_some());
    };
    (0..whole.len()).for_each(|cut| check(&whole[..cut], format!("cut to {cut}")));
    for bit in 0..8 * whole.len() {
        let mut flipped = whole.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        check(&flipped, format!("bit {bit}"));
    }
    mangle(&*store, &name, &whole);
    assert!(open(&store).1.is_empty());
}

#[test]
fn a_corrupt_record_is_named_and_set_aside() {
    for garbage in [&b""[..], b"{", b"[]", b"\xff\xfe", b"{\"version\":", &[b'['; 100_000]] {
        on_each_store(|store| {
            two_units(&store);
            mangle(&*store, &record(&cast(1)), garbage);
            let (ledger, findings, swept) = open(&store);
            assert_eq!(units(&ledger), [(build().unit(), vec!["scene.none-1.cache".to_owned()])]);
            let [found] = &findings.corrupt[..] else { panic!("{findings:?}") };
            assert!(found.unit == cast(1).unit() && found.why.contains("unit record"), "{found:?}");
            let kept = format!("corrupt/{}.json", cast(1).unit());
            assert_eq!(found.kept.as_deref(), Some(kept.as_str()));
            assert_eq!(&*store.open(&kept).unwrap(), garbage);
            assert_eq!(swept, ["segments/a.none-1.seg", "segments/b.none-1.seg"]);
            assert!(open(&store).1.is_empty(), "it is reported once");
            let files = vec![put(&*store, "segments/a.none-1.seg", b"again")];
            assert_eq!(ledger.commit(&cast(1), files).unwrap(), Committed::Now);
            assert!(open(&store).0.is_done(&cast(1).unit()));
        });
    }
}

#[test]
fn another_version_is_refused_and_nothing_changes() {
    on_each_store(|store| {
        let ledger = two_units(&store);
        mangle(&*store, &record(&cast(1)), br#"{"version":2,"anything":"else"}"#);
        let before = store.list("").unwrap();
        for refused in [Ledger::open, Ledger::read] {
            let why = refused(Arc::clone(&store)).unwrap_err();
            let words = format!("{}.json: a unit record of version 2; this gonio reads version 1: use", cast(1).unit());
            assert!(why.to_string().contains(&words) && why.malformed_file().is_none(), "{why}");
        }
        assert!(ledger.commit(&cast(1), vec![]).is_err(), "such a record is not replaced");
        assert_eq!(store.list("").unwrap(), before);
    });
}

#[test]
fn a_unit_is_committed_only_with_its_files() {
    on_each_store(|store| {
        let ledger = two_units(&store);
        let seg = put(&*store, "segments/c.none-1.seg", b"c");
        let other = |change: &dyn Fn(&mut FileEntry)| {
            let mut entry = seg.clone();
            change(&mut entry);
            vec![entry]
        };
        let before = store.list("").unwrap();
        let refused = [
            (other(&|f| f.bytes = 2), "has 1 bytes instead of 2"),
            (other(&|f| f.name = "segments/x.none-1.seg".into()), "segments/x.none-1.seg is not there"),
            (other(&|f| f.name = "../x".into()), "cannot name a file of a run"),
            (other(&|f| f.name = record(&build())), "is in a folder that no unit may write to"),
            (other(&|f| f.name = "corrupt/x".into()), "is in a folder that no unit may write to"),
            (vec![seg.clone(), seg.clone()], "segments/c.none-1.seg is named twice"),
            (ledger.files(&build().unit()).unwrap().to_vec(), "file scene.none-1.cache belongs to unit build-"),
        ];
        for (files, words) in refused {
            let why = ledger.commit(&cast(2), files).unwrap_err().to_string();
            assert!(why.starts_with(&format!("unit {} cannot be committed: ", cast(2).unit())), "{why}");
            assert!(why.contains(words), "{why}");
            assert_eq!((ledger.len(), store.list("").unwrap()), (2, before.clone()));
        }
        assert_eq!(ledger.commit(&cast(2), vec![seg]).unwrap(), Committed::Now);
        assert_eq!(units(&open(&store).0), units(&ledger));
    });
}

#[test]
fn the_slower_one_goes_on_with_the_winners_files() {
    on_each_store(|store| {
        let slower = two_units(&store);
        let faster = Ledger::read(Arc::clone(&store)).unwrap().0;
        let common = put(&*store, "segments/common.none-1.seg", b"s");
        let won = vec![common.clone(), put(&*store, "segments/c.none-2.seg", b"c")];
        assert_eq!(faster.commit(&cast(2), won.clone()).unwrap(), Committed::Now);
        let own = vec![common, put(&*store, "segments/c.none-3.seg", b"c")];
        assert_eq!(slower.commit(&cast(2), own).unwrap(), Committed::Already);
        assert_eq!(slower.files(&cast(2).unit()).unwrap().to_vec(), won);
        assert_eq!(store.size("segments/c.none-3.seg").unwrap(), None, "the loser's file is removed");
        // Whoever commits twice loses against himself, and keeps his files.
        assert_eq!(faster.commit(&cast(2), won.clone()).unwrap(), Committed::Already);
        let (again, findings, swept) = open(&store);
        assert_eq!(
            (again.files(&cast(2).unit()).unwrap().to_vec(), findings, swept),
            (won, Findings::default(), vec![])
        );
    });
}

#[test]
fn an_unsound_record_wins_against_nobody() {
    on_each_store(|store| {
        two_units(&store);
        mangle(&*store, &record(&cast(1)), b"{");
        store.remove("scene.none-1.cache").unwrap();
        let (ledger, findings) = Ledger::read(Arc::clone(&store)).unwrap();
        assert_eq!((findings.corrupt.len(), findings.lost.len()), (1, 1));
        for recipe in [cast(1), build()] {
            let files = vec![put(&*store, &format!("segments/{}.none-1.seg", recipe.what()), b"again")];
            assert_eq!(ledger.commit(&recipe, files.clone()).unwrap(), Committed::Now);
            assert_eq!(open(&store).0.files(&recipe.unit()).unwrap().to_vec(), files);
        }
    });
}

#[test]
fn a_forgotten_unit_takes_its_files_along() {
    on_each_store(|store| {
        let ledger = two_units(&store);
        ledger.forget([cast(1).unit(), cast(7).unit()]).unwrap();
        assert_eq!(store.list("").unwrap(), ["scene.none-1.cache", &record(&build())]);
        assert_eq!(units(&open(&store).0), units(&ledger));
        assert!(ledger.find(PhaseName::Cast, "1").is_empty());
        let again = vec![put(&*store, "segments/a.none-1.seg", b"again")];
        assert_eq!(ledger.commit(&cast(1), again).unwrap(), Committed::Now);
    });
}

#[test]
fn a_corrupt_file_is_kept_and_its_unit_forgotten() {
    on_each_store(|store| {
        let ledger = two_units(&store);
        assert_eq!(ledger.set_aside(&store.path("photo.jpg")).unwrap(), None);
        assert_eq!(ledger.set_aside(&store.path(&record(&cast(7)))).unwrap(), None);
        let found = ledger.set_aside(&store.path("segments/a.none-1.seg")).unwrap().unwrap();
        assert_eq!((found.unit, found.kept.as_str()), (cast(1).unit(), "corrupt/a.none-1.seg"));
        assert_eq!(store.list("").unwrap(), ["corrupt/a.none-1.seg", "scene.none-1.cache", &record(&build())]);
        let (again, findings, _) = open(&store);
        assert_eq!((units(&again), findings), (units(&ledger), Findings::default()));
        assert!(again.of_phase(PhaseName::Cast).is_empty() && again.of_phase(PhaseName::Build).len() == 1);
    });
}

#[test]
fn a_corrupt_record_is_kept_and_its_unit_forgotten() {
    on_each_store(|store| {
        let ledger = two_units(&store);
        mangle(&*store, &record(&cast(1)), b"{");
        let why = ledger.recipe(&cast(1).unit()).unwrap_err();
        let found = ledger.set_aside(why.malformed_file().unwrap()).unwrap().unwrap();
        let kept = format!("corrupt/{}.json", cast(1).unit());
        assert_eq!((found.unit, &found.kept), (cast(1).unit(), &kept));
        assert_eq!(store.list("").unwrap(), [&kept, "scene.none-1.cache", &record(&build())]);
        assert_eq!(ledger.len(), 1);
    });
}

#[test]
fn a_unit_that_another_process_has_done_again_is_left_alone() {
    on_each_store(|store| {
        let late = two_units(&store);
        let other = Ledger::read(Arc::clone(&store)).unwrap().0;
        let corrupt = store.path("segments/a.none-1.seg");
        other.set_aside(&corrupt).unwrap();
        let again = vec![put(&*store, "segments/a2.none-1.seg", b"aa")];
        assert_eq!(other.commit(&cast(1), again.clone()).unwrap(), Committed::Now);
        let found = late.set_aside(&corrupt).unwrap().unwrap();
        assert_eq!((found.unit, found.kept.as_str()), (cast(1).unit(), "corrupt/a.none-1.seg"));
        assert_eq!(late.files(&cast(1).unit()).unwrap().to_vec(), again);
        assert!(open(&store).0.is_done(&cast(1).unit()));
        // Two processes may find one fault, or forget one unit.
        let corrupt = store.path("segments/a2.none-1.seg");
        assert_eq!(late.set_aside(&corrupt).unwrap(), other.set_aside(&corrupt).unwrap());
        late.forget([build().unit()]).unwrap();
        other.forget([build().unit()]).unwrap();
    });
}

#[test]
fn names_in_a_record_cannot_leave_the_store_nor_take_what_is_anothers() {
    on_each_store(|store| {
        let file = |name: &str| FileEntry { name: name.into(), bytes: 5, checksum: Key::of_bytes(b"cache") };
        for (files, words) in [
            (vec![file("../../x")], "cannot name a file of a run"),
            (vec![file("units/x")], "is in a folder that no unit may write to"),
            (vec![file("scene.none-1.cache"), file("scene.none-1.cache")], "is named twice"),
            (vec![file("scene.none-1.cache")], "file scene.none-1.cache belongs to unit build-"),
            (vec![file("scene.none-1.cache"), file("gone")], "gone is not there"),
        ] {
            two_units(&store);
            mangle(&*store, &record(&cast(3)), &UnitRecord::new(&cast(3), files).seal().unwrap());
            let (ledger, findings, _) = open(&store);
            let found = [why(&findings.corrupt), why(&findings.lost)].concat();
            assert!(found.len() == 1 && found[0].0 == cast(3).unit() && found[0].1.contains(words), "{found:?}");
            assert_eq!(ledger.len(), 2, "the others stay, with their files");
            ledger.forget([cast(1).unit(), build().unit()]).unwrap();
        }
        let sound = UnitRecord::new(&cast(2), vec![]).seal().unwrap();
        mangle(&*store, &record(&cast(1)), &sound);
        let findings = open(&store).1;
        assert!(findings.corrupt[0].why.contains("under the name of another unit"), "{findings:?}");
    });
}

#[test]
fn other_files_among_the_records_are_left_alone() {
    on_each_store(|store| {
        two_units(&store);
        let strange = ["units/README", "units/cast-12.json", "units/deep/x.json", "units/light-00.json"];
        strange.iter().for_each(|name| drop(put(&*store, name, b"strange")));
        let (ledger, findings, swept) = open(&store);
        assert!(ledger.len() == 2 && findings.is_empty() && swept.is_empty());
        assert!(strange.iter().all(|name| store.size(name).unwrap().is_some()));
    });
}

#[test]
fn reading_changes_nothing() {
    on_each_store(|store| {
        assert!(Ledger::read(Arc::clone(&store)).unwrap().0.is_empty());
        let written = two_units(&store);
        put(&*store, "segments/under-way.seg", b"x");
        mangle(&*store, &record(&cast(3)), b"{");
        let before = store.list("").unwrap();
        let (read, findings) = Ledger::read(Arc::clone(&store)).unwrap();
        assert_eq!((units(&read), findings.corrupt.len()), (units(&written), 1));
        assert_eq!(findings.corrupt[0].kept, None);
        assert_eq!(store.list("").unwrap(), before);
    });
}

#[test]
fn threads_may_commit_at_once() {
    on_each_store(|store| {
        let ledger = two_units(&store);
        let won: Vec<u32> = std::thread::scope(|scope| {
            let run = |thread: u32| {
                let (ledger, store) = (&ledger, &store);
                let commit = move |unit: &u32| {
                    let files = vec![put(&**store, &format!("segments/{unit}.{thread}.seg"), b"same")];
                    ledger.commit(&cast(100 + unit), files).unwrap() == Committed::Now
                };
                scope.spawn(move || (0..8).filter(commit).collect::<Vec<_>>())
            };
            let threads: Vec<_> = (0..4).map(run).collect();
            threads.into_iter().flat_map(|thread| thread.join().unwrap()).collect()
        });
        assert_eq!((won.len(), won.into_iter().collect::<BTreeSet<_>>().len()), (8, 8), "each unit is won once");
        let (again, findings, swept) = open(&store);
        assert_eq!((units(&again), findings, swept), (units(&ledger), Findings::default(), vec![]));
    });
}
