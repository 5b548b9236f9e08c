//! The manifest: what it names survives, what it does not name goes, and no mangled one is believed.

use std::sync::Arc;

use super::{mangle, on_each_store, put};
use crate::disk::{FileEntry, Manifest, MemStore, Opening, Recipe, Store, Unit};

const OWNED: [&str; 2] = ["segments/", "scene.cache"];

fn open(store: &Arc<dyn Store>) -> (Manifest, Opening) {
    Manifest::open(Arc::clone(store), &OWNED).unwrap()
}

fn map(number: u32) -> Recipe {
    Recipe::new("map").with("number", number)
}

fn scene() -> Recipe {
    Recipe::new("scene")
}

/// A run with two units and three files.
fn two_units(store: &Arc<dyn Store>) -> Manifest {
    let (mut manifest, opening) = open(store);
    assert_eq!(opening, Opening::default());
    let files = vec![put(&**store, "segments/a.seg", b"aa"), put(&**store, "segments/b.seg", b"")];
    manifest.commit([(map(1), files)]).unwrap();
    manifest.commit([(scene(), vec![put(&**store, "scene.cache", b"cache")])]).unwrap();
    manifest
}

#[test]
fn what_is_named_survives_and_the_rest_is_swept() {
    on_each_store(|store| {
        let units = two_units(&store).units().clone();
        for round in 0..10 {
            // As a run leaves it that is killed after its files and before its manifest.
            put(&*store, "segments/c.seg", &[round]);
            put(&*store, "segments/deep/d.seg", b"d");
            let _draft = store.create("segments/e.seg").unwrap();
            mangle(&*store, "photo.jpg", b"the user's own");
            let (manifest, opening) = open(&store);
            assert_eq!(manifest.units(), &units);
            assert_eq!(manifest.files(&map(1).unit()).map(<[_]>::len), Some(2));
            assert!(manifest.files(&map(2).unit()).is_none());
            assert!(opening.lost.is_empty() && opening.set_aside.is_none());
            let committed = opening.swept.iter().filter(|name| name.ends_with(".seg")).collect::<Vec<_>>();
            assert_eq!(committed, ["segments/c.seg", "segments/deep/d.seg"]);
            let kept =
                ["manifest.copy.json", "manifest.json", "photo.jpg", "scene.cache", "segments/a.seg", "segments/b.seg"];
            assert_eq!(store.list("").unwrap(), kept);
        }
    });
}

#[test]
fn an_unnamed_single_file_is_swept_too() {
    on_each_store(|store| {
        put(&*store, "scene.cache", b"made, but never named");
        assert_eq!(open(&store).1.swept, ["scene.cache"]);
    });
}

#[test]
fn units_with_missing_files_are_lost_and_named() {
    on_each_store(|store| {
        two_units(&store);
        store.remove("segments/b.seg").unwrap();
        mangle(&*store, "scene.cache", b"longer than it was");
        let (manifest, opening) = open(&store);
        assert!(manifest.units().is_empty());
        let lost = [(map(1), "segments/b.seg is not there"), (scene(), "scene.cache has 18 bytes instead of 5")];
        assert_eq!(opening.lost, lost.map(|(recipe, why)| (recipe.unit(), why.to_owned())));
        assert_eq!(opening.swept, ["segments/a.seg"]);
        assert_eq!(&*store.open("corrupt/scene.cache").unwrap(), b"longer than it was");
        assert_eq!(open(&store).1, Opening::default(), "it is reported once");
    });
}

#[test]
fn every_truncation_and_every_flipped_bit_is_set_aside_or_refused() {
    // In memory alone: thousands of files, each synced, take a disk minutes.
    let store: Arc<dyn Store> = Arc::new(MemStore::new());
    let units = two_units(&store).units().clone();
    let whole = store.open("manifest.json").unwrap().to_vec();
    let believed = |bytes: &[u8]| {
        mangle(&*store, "manifest.json", bytes);
        Manifest::read(Arc::clone(&store)).is_ok_and(|m| {
            assert_eq!(m.units(), &units, "a mangled manifest is believed");
            true
        })
    };
    // All but the last newline is needed.
    assert!((0..whole.len() - 1).all(|cut| !believed(&whole[..cut])));
    let mut harmless = 0;
    for bit in 0..8 * whole.len() {
        let mut flipped = whole.clone();
        flipped[bit / 8] ^= 1 << (bit % 8);
        harmless += usize::from(believed(&flipped));
    }
    assert!(harmless < whole.len() / 4, "{harmless}: only white space may change");
    assert!(believed(&whole));
}

#[test]
fn a_corrupt_manifest_is_named_and_set_aside_and_its_copy_stands_in() {
    for garbage in [&b""[..], b"{", b"[]", b"\xff\xfe", b"{\"version\": 2}", &[b'['; 100_000]] {
        on_each_store(|store| {
            let units = two_units(&store).units().clone();
            mangle(&*store, "manifest.json", garbage);
            assert!(Manifest::read(Arc::clone(&store)).is_err());
            let (manifest, opening) = open(&store);
            let (name, why) = opening.set_aside.unwrap();
            assert!(opening.copied && opening.swept.is_empty() && !why.is_empty());
            assert_eq!(manifest.units(), &units);
            assert_eq!(&*store.open(&name).unwrap(), garbage);
            assert_eq!(open(&store).1, Opening::default(), "it is reported once");
        });
    }
}

#[test]
fn a_copy_that_is_one_commit_behind_loses_that_one_alone() {
    on_each_store(|store| {
        let mut manifest = two_units(&store);
        let before = manifest.units().clone();
        let copy = store.open("manifest.copy.json").unwrap().to_vec();
        manifest.commit([(map(2), vec![put(&*store, "segments/c.seg", b"c")])]).unwrap();
        mangle(&*store, "manifest.copy.json", &copy);
        mangle(&*store, "manifest.json", b"{");
        let (manifest, opening) = open(&store);
        assert_eq!((manifest.units(), opening.swept), (&before, vec!["segments/c.seg".to_owned()]));
    });
}

#[test]
fn without_a_sound_copy_all_units_are_lost() {
    for copy in [&b"{"[..], br#"{"version": 7}"#] {
        on_each_store(|store| {
            two_units(&store);
            mangle(&*store, "manifest.json", b"{");
            mangle(&*store, "manifest.copy.json", copy);
            let (manifest, opening) = open(&store);
            assert!(manifest.units().is_empty() && !opening.copied && opening.set_aside.is_some());
            assert_eq!(opening.swept.len(), 3);
            assert_eq!(open(&store).1, Opening::default(), "it is reported once");
        });
    }
}

#[test]
fn a_corrupt_file_is_kept_and_its_unit_forgotten() {
    on_each_store(|store| {
        let mut manifest = two_units(&store);
        assert_eq!(manifest.set_aside(&store.path("photo.jpg")).unwrap(), None);
        let found = manifest.set_aside(&store.path("segments/a.seg")).unwrap();
        assert_eq!(found, Some((map(1).unit(), "corrupt/a.seg".to_owned())));
        let kept = ["corrupt/a.seg", "manifest.copy.json", "manifest.json", "scene.cache"];
        assert_eq!(store.list("").unwrap(), kept);
        let (again, opening) = open(&store);
        assert_eq!((again.units(), opening), (manifest.units(), Opening::default()));
        assert!(again.of_kind("map").next().is_none() && again.of_kind("scene").count() == 1);
    });
}

#[test]
fn another_version_is_refused_and_nothing_is_swept() {
    on_each_store(|store| {
        two_units(&store);
        let before = store.list("").unwrap();
        mangle(&*store, "manifest.json", br#"{"version": 3, "anything": "else"}"#);
        let why = Manifest::open(Arc::clone(&store), &OWNED).unwrap_err().to_string();
        assert!(why.contains("manifest.json: a manifest of version 3; this gonio reads version 2: use"), "{why}");
        assert_eq!(store.list("").unwrap(), before);
    });
}

#[test]
fn a_unit_is_committed_once_and_only_with_its_files() {
    on_each_store(|store| {
        let mut manifest = two_units(&store);
        let before = store.open("manifest.json").unwrap().to_vec();
        let seg = put(&*store, "segments/c.seg", b"c");
        let other = |change: &dyn Fn(&mut FileEntry)| {
            let mut entry = seg.clone();
            change(&mut entry);
            vec![entry]
        };
        let refused = [
            (scene(), vec![seg.clone()], "is committed already"),
            (map(2), other(&|f| f.bytes = 2), "has 1 bytes instead of 2"),
            (map(2), other(&|f| f.name = "segments/x.seg".into()), "is not there"),
            (map(2), other(&|f| f.name = "../x".into()), "is no name"),
            (map(2), vec![seg.clone(), seg.clone()], "is named twice"),
            (map(2), manifest.files(&scene().unit()).unwrap().to_vec(), "scene.cache is named twice"),
        ];
        for (unit, files, words) in refused {
            let why = manifest.commit([(unit, files)]).unwrap_err().to_string();
            assert!(why.contains(words), "{why}");
            assert_eq!(manifest.units().len(), 2);
            assert_eq!(&*store.open("manifest.json").unwrap(), before);
        }
        manifest.commit([(map(2), vec![seg]), (Recipe::new("empty"), vec![])]).unwrap();
        assert_eq!(open(&store).0.units(), manifest.units());
    });
}

#[test]
fn a_forgotten_unit_takes_its_files_along() {
    on_each_store(|store| {
        let mut manifest = two_units(&store);
        manifest.forget([map(1).unit().as_str(), "never was"]).unwrap();
        assert_eq!(store.list("").unwrap(), ["manifest.copy.json", "manifest.json", "scene.cache"]);
        assert_eq!(open(&store).0.units(), manifest.units());
        let again = vec![put(&*store, "segments/a.seg", b"again")];
        manifest.commit([(map(1), again)]).unwrap();
    });
}

#[test]
fn names_in_a_manifest_cannot_leave_the_store() {
    on_each_store(|store| {
        let escape = FileEntry { name: "../../x".into(), bytes: 1, checksum: String::new() };
        let refused = |name: String, unit: Unit| {
            let units: super::super::manifest::Units = [(name, unit)].into();
            let sum = blake3::hash(&serde_json::to_vec(&units).unwrap()).to_hex();
            let text = serde_json::json!({"version": 2, "checksum": sum.as_str(), "units": units}).to_string();
            mangle(&*store, "manifest.json", text.as_bytes());
            mangle(&*store, "manifest.copy.json", text.as_bytes());
            open(&store).1.set_aside.unwrap().1
        };
        let why = refused(scene().unit(), Unit { recipe: scene(), files: vec![escape] });
        assert!(why.contains("is no name for a file of a run"), "{why}");
        let why = refused(map(1).unit(), Unit { recipe: map(2), files: vec![] });
        assert!(why.contains("is not what its name says"), "{why}");
    });
}

#[test]
fn reading_changes_nothing() {
    on_each_store(|store| {
        assert!(Manifest::read(Arc::clone(&store)).unwrap().units().is_empty());
        let written = two_units(&store);
        put(&*store, "segments/under-way.seg", b"x");
        let read = Manifest::read(Arc::clone(&store)).unwrap();
        assert_eq!(read.units(), written.units());
        assert!(store.size("segments/under-way.seg").unwrap().is_some());
    });
}
