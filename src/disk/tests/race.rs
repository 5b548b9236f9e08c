//! Two processes that do the same units at the same time.

use std::collections::BTreeMap;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};
use std::sync::Arc;
use std::time::{Duration, Instant};

use super::ledger::{cast, open};
use super::put;
use crate::disk::frozen::Frozen;
use crate::disk::{Committed, DirStore, Ledger, Store};

const ROUNDS: u32 = 50;
const FOLDER: &str = "GONIO_TEST_RACE";
const RACER: &str = "GONIO_TEST_RACER";

/// Waits until both racers have come here.
fn meet(folder: &Path, racer: &str, round: u32) {
    let other = if racer == "a" { "b" } else { "a" };
    fs::write(folder.join(format!("{round}.{racer}")), "").unwrap();
    let since = Instant::now();
    while !folder.join(format!("{round}.{other}")).exists() {
        assert!(since.elapsed() < Duration::from_secs(60), "the other racer does not come");
        std::thread::yield_now();
    }
}

fn bytes(round: u32) -> Vec<u8> {
    format!("the bytes of unit {round}").repeat(100).into_bytes()
}

/// One of the two processes; run by the test below.
#[test]
#[ignore = "run by two_processes_commit_each_unit_once"]
fn racer() {
    let (folder, racer) = (std::env::var_os(FOLDER).unwrap(), std::env::var(RACER).unwrap());
    let (work, meeting) = (Path::new(&folder).join("work"), Path::new(&folder).join("meeting"));
    let store: Arc<dyn Store> = Arc::new(DirStore::new(work));
    let ledger = Ledger::read(Arc::clone(&store)).unwrap().0;
    let mut list = Frozen::<u32>::read(Arc::clone(&store), "groups").unwrap().0;
    for round in 0..ROUNDS {
        let recipe = cast(round);
        let name = format!("segments/{}.{}-1.seg", recipe.unit(), store.attempt());
        let files = vec![put(&*store, &name, &bytes(round))];
        meet(&meeting, &racer, round);
        let committed = ledger.commit(&recipe, files).unwrap();
        let file = ledger.files(&recipe.unit()).unwrap()[0].clone();
        assert_eq!(&*file.verify(&*store).unwrap(), bytes(round));
        assert_eq!(file.name == name, committed == Committed::Now);
        while !list.items().contains(&round) {
            list.add(vec![round]).unwrap();
        }
        println!("\nround {round} {committed:?} {}", file.name);
    }
    println!("\nlist {:?}", list.items());
}

#[test]
fn two_processes_commit_each_unit_once() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("meeting")).unwrap();
    let start = |racer: &str| {
        Command::new(std::env::current_exe().unwrap())
            .args(["disk::tests::race::racer", "--exact", "--ignored", "--nocapture"])
            .env(FOLDER, folder.path())
            .env(RACER, racer)
            .stdout(Stdio::piped())
            .stderr(Stdio::piped())
            .spawn()
            .unwrap()
    };
    let racers = ["a", "b"].map(start).map(|racer| racer.wait_with_output().unwrap());
    let mut rounds = BTreeMap::<String, Vec<(String, String)>>::new();
    let mut lists = Vec::new();
    for done in &racers {
        assert!(done.status.success(), "{done:?}");
        let said = String::from_utf8(done.stdout.clone()).unwrap();
        lists.extend(said.lines().filter_map(|line| line.strip_prefix("list ").map(str::to_owned)));
        for line in said.lines().filter_map(|line| line.strip_prefix("round ")) {
            let [round, committed, file] = line.split(' ').collect::<Vec<_>>()[..] else { panic!("{line}") };
            rounds.entry(round.to_owned()).or_default().push((committed.to_owned(), file.to_owned()));
        }
    }
    assert_eq!(rounds.len(), ROUNDS as usize);
    for (round, told) in rounds {
        let [(one, file), (other, same)] = &told[..] else { panic!("round {round}: {told:?}") };
        assert!(one != other && file == same, "round {round}: {told:?}");
    }
    assert_eq!((lists.len(), &lists[0]), (2, &format!("{:?}", (0..ROUNDS).collect::<Vec<_>>())));
    assert_eq!(lists[0], lists[1]);
    let store: Arc<dyn Store> = Arc::new(DirStore::new(folder.path().join("work")));
    assert_eq!(store.list("segments").unwrap().len(), ROUNDS as usize, "the losers' files are gone");
    let (ledger, findings, swept) = open(&store);
    assert!(ledger.len() == ROUNDS as usize && findings.is_empty() && swept.is_empty(), "{findings:?} {swept:?}");
}
