//! The lock: one process holds it, the other is told which, and it ends with its process.

use std::fs;
use std::io::{BufRead, BufReader};
use std::process::{Command, Stdio};

use crate::disk::{DirStore, Lock};

#[test]
fn a_second_run_is_refused_by_name() {
    let folder = tempfile::tempdir().unwrap();
    let work = folder.path().join("work/scene");
    let first = Lock::acquire(&DirStore::new(&work)).unwrap();
    let why = Lock::acquire(&DirStore::new(&work)).unwrap_err().to_string();
    assert!(why.contains(&format!("is in use by process {}: wait", std::process::id())), "{why}");
    drop(first);
    drop(Lock::acquire(&DirStore::new(&work)).unwrap());
}

#[test]
fn what_a_lock_file_says_is_not_what_locks() {
    let folder = tempfile::tempdir().unwrap();
    drop(Lock::acquire(&DirStore::new(folder.path())).unwrap());
    let own = format!("{}\n", std::process::id());
    for said in ["1\n", "", "not a number", "99999999999999999999999999999999", "\0\0\0"] {
        fs::write(folder.path().join("lock"), said).unwrap();
        let held = Lock::acquire(&DirStore::new(folder.path())).unwrap();
        // What no lock wrote stays.
        let is_ours = said.is_empty() || said == "1\n";
        assert_eq!(fs::read_to_string(folder.path().join("lock")).unwrap(), if is_ours { &own } else { said });
        fs::write(folder.path().join("lock"), said).unwrap();
        assert!(Lock::acquire(&DirStore::new(folder.path())).unwrap_err().to_string().contains("is in use by"));
        drop(held);
    }
}

/// Holds a lock until it is killed; run by the test below in a process of its own.
#[test]
#[ignore = "run by a_killed_process_holds_nothing"]
fn hold() {
    let _lock = Lock::acquire(&DirStore::new(std::env::var_os("GONIO_TEST_LOCK").unwrap())).unwrap();
    println!("\nheld");
    std::thread::sleep(std::time::Duration::from_secs(60));
}

#[test]
fn a_killed_process_holds_nothing() {
    let folder = tempfile::tempdir().unwrap();
    let mut child = Command::new(std::env::current_exe().unwrap())
        .args(["disk::tests::lock::hold", "--exact", "--ignored", "--nocapture"])
        .env("GONIO_TEST_LOCK", folder.path())
        .stdout(Stdio::piped())
        .spawn()
        .unwrap();
    let mut said = BufReader::new(child.stdout.take().unwrap()).lines().map_while(Result::ok);
    assert!(said.any(|line| line == "held"));
    let why = Lock::acquire(&DirStore::new(folder.path())).unwrap_err().to_string();
    child.kill().unwrap();
    child.wait().unwrap();
    assert!(why.contains(&format!("process {}", child.id())), "{why}");
    drop(Lock::acquire(&DirStore::new(folder.path())).unwrap());
}
