//! The mark: a folder of others is refused and stays as it is.

use std::collections::BTreeMap;
use std::fs;
use std::path::{Path, PathBuf};

use crate::disk::mark::{MARK, foreign};
use crate::disk::{DirStore, Lock};

/// Every entry below a folder and what it holds; links are not followed.
fn contents(folder: &Path) -> BTreeMap<PathBuf, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap() {
        let entry = entry.unwrap();
        if entry.file_type().unwrap().is_dir() {
            found.insert(entry.path(), Vec::new());
            found.extend(contents(&entry.path()));
        } else {
            found.insert(entry.path(), fs::read(entry.path()).unwrap_or_default());
        }
    }
    found
}

#[test]
fn a_folder_of_others_is_refused_and_stays_as_it_is() {
    let files: [&[&str]; 7] = [
        &["scene/mesh.ply", "scene/images/a.jpg"],
        &["materials.npy"],
        &["segments/survey.csv", "export/scene.ply"],
        &["deep/my.gonio-tmp"],
        &["my.gonio-tmp"],
        &["lock"],
        &["units/cast-1.json"],
    ];
    for names in files {
        let folder = tempfile::tempdir().unwrap();
        for name in names {
            let path = folder.path().join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, "precious").unwrap();
        }
        let before = contents(folder.path());
        let why = Lock::acquire(&DirStore::new(folder.path())).unwrap_err().to_string();
        let first = names[0].split('/').next().unwrap();
        assert!(why.contains(first) && why.contains("left alone; give this run a new or empty folder"), "{why}");
        assert_eq!(contents(folder.path()), before, "{names:?}");
    }
}

#[test]
fn what_is_called_a_mark_is_none() {
    for text in ["", "mark", "the folder of a run of gonio"] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join(MARK), text).unwrap();
        let why = Lock::acquire(&DirStore::new(folder.path())).unwrap_err().to_string();
        assert!(why.contains("holds a gonio-run that is no mark of gonio's, or that changed since"), "{why}");
        assert_eq!(fs::read_to_string(folder.path().join(MARK)).unwrap(), text);
    }
    #[cfg(unix)]
    {
        let (ours, folder) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
        drop(Lock::acquire(&DirStore::new(ours.path())).unwrap());
        std::os::unix::fs::symlink(ours.path().join(MARK), folder.path().join(MARK)).unwrap();
        assert!(Lock::acquire(&DirStore::new(folder.path())).is_err(), "a link to another run's mark");
    }
}

#[test]
fn an_empty_folder_becomes_a_runs_and_stays_one() {
    let folder = tempfile::tempdir().unwrap();
    let work = folder.path().join("a/b");
    assert_eq!(foreign(&work).unwrap(), None);
    assert!(!work.exists(), "looking makes nothing");
    drop(Lock::acquire(&DirStore::new(&work)).unwrap());
    let mark = fs::read(work.join(MARK)).unwrap();
    fs::write(work.join("report.json"), "{}").unwrap();
    drop(Lock::acquire(&DirStore::new(&work)).unwrap());
    assert_eq!(fs::read(work.join(MARK)).unwrap(), mark, "the id stays");
    // Whoever was killed while making the mark left the folder as good as empty.
    let killed = folder.path().join("killed");
    fs::create_dir(&killed).unwrap();
    fs::write(killed.join(format!("{MARK}.1-2.gonio-tmp")), "The fol").unwrap();
    drop(Lock::acquire(&DirStore::new(&killed)).unwrap());
}

#[test]
fn an_older_gonios_folder_is_refused_in_one_sentence() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("manifest.json"), "{}").unwrap();
    let why = Lock::acquire(&DirStore::new(folder.path())).unwrap_err().to_string();
    assert!(
        why.contains("holds manifest.json of an older gonio, which kept its units there: it is left alone"),
        "{why}"
    );
}
