//! Runs that are told to stop: by which signals, and how long that may take.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use tempfile::TempDir;

use crate::files::{outputs, quick};
use crate::ran::Ran;

fn start(dir: &TempDir, script: &str) -> Child {
    let mut command = Command::new("sh");
    command.current_dir(dir.path()).args(["-c", script]).env("GONIO", env!("CARGO_BIN_EXE_gonio"));
    command.stdout(Stdio::null()).stderr(Stdio::null()).spawn().unwrap()
}

fn signal(name: &str, run: &Child) {
    Command::new("kill").args([&format!("-{name}"), &run.id().to_string()]).stderr(Stdio::null()).status().unwrap();
}

/// Waits until the run has done a unit more than it had, or has ended.
fn midst(work: &Path, run: &mut Child) {
    let done = || fs::read_dir(work.join("units")).map_or(0, Iterator::count);
    let before = done();
    while done() == before && run.try_wait().unwrap().is_none() {
        sleep(Duration::from_millis(1));
    }
}

#[test]
fn every_signal_that_asks_for_an_end_drains_within_its_grace() {
    let dir = quick();
    let run = |sets: &str| format!("exec \"$GONIO\" run p.toml --set gather.group=1 {sets}");
    Ran::script(dir.path(), &run("--set run.work=whole")).ends(0);
    let whole = outputs(&dir.path().join("whole"));
    for (name, sets) in [("HUP", ""), ("TERM", "--set run.grace=0"), ("XCPU", ""), ("INT", "--set run.grace=0")] {
        let work = dir.path().join(name);
        let mut stopped = 0;
        let script = run(&format!("{sets} --set run.work={name}"));
        for _ in 0..40 {
            let mut running = start(&dir, &script);
            midst(&work, &mut running);
            signal(name, &running);
            match running.wait().unwrap().code() {
                Some(130) => stopped += 1,
                code => {
                    assert_eq!(code, Some(0), "{name}");
                    break;
                }
            }
        }
        Ran::script(dir.path(), &script).ends(0);
        assert!(stopped > 0, "no run was stopped by {name}");
        assert!(outputs(&work) == whole, "{name}");
    }
}

#[test]
fn a_hangup_that_is_ignored_stays_ignored() {
    let dir = quick();
    let mut running = start(&dir, "trap '' HUP; exec \"$GONIO\" run p.toml");
    midst(&dir.path().join("work"), &mut running);
    signal("HUP", &running);
    assert_eq!(running.wait().unwrap().code(), Some(0));
}

#[test]
fn a_thread_that_is_stuck_does_not_keep_the_process() {
    let dir = quick();
    // Standard output is a full pipe that nobody reads: what shows progress is stuck, and the run waits for it at its end.
    let script = r#"
        mkfifo pipe; sleep 60 <pipe & reader=$!; exec 9>pipe; head -c 65536 /dev/zero >&9
        "$GONIO" run p.toml --json --set run.grace=0 >&9 & run=$!
        while [ ! -e work/report.json ]; do sleep 0.05; done
        kill -TERM $run; wait $run; code=$?; kill $reader; exit $code"#;
    let begun = Instant::now();
    let ran = Ran::script(dir.path(), script);
    ran.ends(130).says("did not end in time; the same command goes on from here");
    assert!((2..20).contains(&begun.elapsed().as_secs()), "{ran}");
    Ran::gonio(dir.path(), "run p.toml").ends(0);
}
