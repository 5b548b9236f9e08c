//! Links in a run's folder: none is followed, whatever it has the name of, and what it points to stays as it is.

use std::fs;
use std::os::unix::fs::symlink;
use std::path::Path;

use super::put;
use crate::disk::{DirStore, Lock, Store};

/// A folder with somebody's files, and a run's folder beside it.
fn two_folders() -> (tempfile::TempDir, DirStore) {
    let dir = tempfile::tempdir().unwrap();
    fs::create_dir_all(dir.path().join("photos")).unwrap();
    for name in ["a.jpg", "x.seg", "x.seg.none-1-1.gonio-tmp", "lock", "1\n"] {
        fs::write(dir.path().join("photos").join(name), "precious").unwrap();
    }
    let store = DirStore::new(dir.path().join("work"));
    fs::create_dir(store.root()).unwrap();
    (dir, store)
}

fn untouched(dir: &Path) -> bool {
    let photos: Vec<_> = fs::read_dir(dir.join("photos")).unwrap().map(|entry| entry.unwrap().path()).collect();
    photos.len() == 5 && photos.iter().all(|path| fs::read(path).unwrap() == b"precious")
}

#[test]
fn a_link_in_a_folders_place_leads_nowhere() {
    let (dir, store) = two_folders();
    symlink(dir.path().join("photos"), store.root().join("segments")).unwrap();
    symlink(dir.path().join("photos"), store.root().join("corrupt")).unwrap();
    put(&store, "x.seg", b"ours");
    assert!(store.sweep().unwrap().is_empty());
    assert_eq!(store.list("").unwrap(), ["x.seg"]);
    assert!(store.list("segments").unwrap().is_empty());
    assert_eq!(store.size("segments/x.seg").unwrap(), None);
    for why in [
        store.create("segments/y.seg").map(drop),
        store.create("segments/deep/y.seg").map(drop),
        store.open("segments/x.seg").map(drop),
        store.read("segments/x.seg").map(drop),
        store.remove("segments/x.seg"),
        store.rename("x.seg", "segments/x.seg"),
        store.rename("x.seg", "corrupt/x.seg"),
        store.rename("segments/x.seg", "y.seg"),
    ] {
        let why = why.unwrap_err().to_string();
        assert!(why.contains("gonio follows no link here, so a link to a folder must be replaced"), "{why}");
    }
    store.sync("segments").unwrap();
    assert!(untouched(dir.path()));
}

#[test]
fn a_link_in_a_files_place_is_neither_read_nor_written() {
    let (dir, store) = two_folders();
    symlink(dir.path().join("photos/a.jpg"), store.root().join("materials.npy")).unwrap();
    symlink(dir.path().join("nothing"), store.root().join("report.json")).unwrap();
    for name in ["materials.npy", "report.json"] {
        assert!(store.open(name).is_err() && store.read(name).is_err(), "{name}");
        assert_eq!(store.size(name).unwrap(), None);
        assert!(store.create(name).is_err(), "{name} is not replaced");
    }
    assert!(store.list("").unwrap().is_empty());
    // What goes is the link.
    store.rename("materials.npy", "corrupt/materials.npy").unwrap();
    assert!(fs::symlink_metadata(store.root().join("corrupt/materials.npy")).unwrap().is_symlink());
    store.remove("report.json").unwrap();
    assert!(untouched(dir.path()) && !dir.path().join("nothing").exists());
}

#[test]
fn a_lock_locks_no_file_of_others() {
    let (dir, store) = two_folders();
    drop(Lock::acquire(&store).unwrap());
    let lock = store.root().join("lock");
    for other in ["photos/lock", "nothing", "photos"] {
        fs::remove_file(&lock).unwrap();
        symlink(dir.path().join(other), &lock).unwrap();
        let why = Lock::acquire(&store).unwrap_err().to_string();
        assert!(why.contains("lock: ") && why.contains("follows no link"), "{why}");
    }
    fs::remove_file(&lock).unwrap();
    rustix::fs::mknodat(rustix::fs::CWD, &lock, rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0).unwrap();
    assert!(Lock::acquire(&store).is_err(), "a pipe");
    // A hard link cannot be told from a file: it is locked, and what it holds stays.
    fs::remove_file(&lock).unwrap();
    fs::hard_link(dir.path().join("photos/lock"), &lock).unwrap();
    drop(Lock::acquire(&store).unwrap());
    assert!(untouched(dir.path()) && !dir.path().join("nothing").exists());
}

#[test]
fn a_folder_that_is_exchanged_meanwhile_is_not_entered() {
    let (dir, store) = two_folders();
    put(&store, "segments/x.seg", b"ours");
    fs::rename(store.root(), dir.path().join("away")).unwrap();
    symlink(dir.path().join("photos"), store.root()).unwrap();
    put(&store, "y.seg", b"ours");
    store.remove("segments/x.seg").unwrap();
    store.sweep().unwrap();
    assert!(dir.path().join("away/y.seg").exists() && !dir.path().join("away/segments/x.seg").exists());
    assert!(untouched(dir.path()));
}
