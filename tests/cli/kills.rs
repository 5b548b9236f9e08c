//! Runs that are killed: whenever it happens, the same command goes on, and the same bytes come out.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tempfile::TempDir;

use crate::files::{city, outputs};
use crate::ran::Ran;

/// A city with its pipeline file, which a network of a few weights makes quick.
fn scene() -> TempDir {
    let dir = city();
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/models/conv4.onnx");
    fs::copy(model, dir.path().join("conv4.onnx")).unwrap();
    dir
}

const SETS: &str = "--set infer.model=conv4.onnx --set infer.backend=embedded --set gather.group=1";

fn start(dir: &TempDir, args: &str) -> Child {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gonio"));
    command.current_dir(dir.path()).args(args.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null());
    command.spawn().unwrap()
}

/// Kills runs into `work` at random instants of the time that a whole one takes, each going on where the one before was
/// killed, until one ends; and so on, `kills` times in all. Every run that ends has the bytes of `expected`.
fn killed_and_resumed(dir: &TempDir, args: &str, work: &Path, expected: &[Vec<u8>], whole: Duration, kills: usize) {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut done = 0;
    while done < kills {
        fs::remove_dir_all(work).unwrap_or_default();
        loop {
            let mut run = start(dir, args);
            sleep(whole.mul_f64(random.random_range(0.0..1.1)));
            if run.try_wait().unwrap().is_some_and(|status| status.success()) {
                break;
            }
            run.kill().unwrap();
            run.wait().unwrap();
            done += 1;
            if done >= kills {
                break;
            }
        }
        Ran::gonio(dir.path(), args).ends(0);
        assert!(outputs(work) == expected, "after {done} kills");
        let left = fs::read_dir(work.join("segments")).unwrap().chain(fs::read_dir(work).unwrap());
        assert!(left.flatten().all(|e| !e.file_name().to_string_lossy().contains("gonio-tmp")), "rubbish is left");
    }
}

fn kill(kills: usize) {
    let dir = scene();
    let args = |work: &str| format!("run p.toml {SETS} --set run.work={work}");
    let started = Instant::now();
    Ran::gonio(dir.path(), &args("whole")).ends(0);
    let whole = started.elapsed();
    let expected = outputs(&dir.path().join("whole"));
    killed_and_resumed(&dir, &args("work"), &dir.path().join("work"), &expected, whole, kills);
}

#[test]
fn a_run_that_is_killed_goes_on_to_the_same_bytes() {
    kill(6);
}

/// As many as `GONIO_KILLS` says, else 200.
#[test]
#[ignore = "minutes; .ci/run runs it"]
fn a_run_that_is_killed_often_goes_on_to_the_same_bytes() {
    kill(std::env::var("GONIO_KILLS").map_or(200, |n| n.parse().unwrap()));
}

/// The demo, whose city is made by the run itself, killed in all its phases. As many as `GONIO_KILLS` says, else 200.
#[test]
#[ignore = "an hour; for a release build"]
fn the_demo_that_is_killed_often_goes_on_to_the_same_bytes() {
    let dir = TempDir::new().unwrap();
    fs::copy(crate::files::pipelines().join("demo.toml"), dir.path().join("p.toml")).unwrap();
    let args = |work: &str| format!("run p.toml --set run.work={work} --set gather.group=4");
    let started = Instant::now();
    Ran::gonio(dir.path(), &args("whole")).ends(0);
    let whole = started.elapsed();
    let expected = outputs(&dir.path().join("whole"));
    let kills = std::env::var("GONIO_KILLS").map_or(200, |n| n.parse().unwrap());
    killed_and_resumed(&dir, &args("work"), &dir.path().join("work"), &expected, whole, kills);
}

#[cfg(unix)]
#[test]
fn an_interrupted_run_commits_what_is_in_flight_and_goes_on() {
    let dir = scene();
    let args = |work: &str| format!("run p.toml {SETS} --set run.work={work}");
    Ran::gonio(dir.path(), &args("whole")).ends(0);
    let expected = outputs(&dir.path().join("whole"));
    let work = dir.path().join("work");
    let mut stopped = 0;
    for _ in 0..40 {
        let mut run = start(&dir, &args("work"));
        // As soon as the manifest names a unit: in the midst of the work.
        let seen = |work: &Path| fs::metadata(work.join("manifest.json")).ok().and_then(|m| m.modified().ok());
        let before = seen(&work);
        while seen(&work) == before && run.try_wait().unwrap().is_none() {
            sleep(Duration::from_millis(1));
        }
        Command::new("kill").arg("-INT").arg(run.id().to_string()).stderr(Stdio::null()).status().unwrap();
        match run.wait().unwrap().code() {
            Some(130) => stopped += 1,
            code => {
                assert_eq!(code, Some(0));
                break;
            }
        }
    }
    assert!(stopped > 0, "no run was stopped");
    assert!(outputs(&work) == expected);
}

#[test]
fn a_second_run_on_the_same_folder_is_refused() {
    let dir = scene();
    let args = format!("run p.toml {SETS} --set run.work=work");
    let lock = gonio::disk::Lock::acquire(dir.path().join("work")).unwrap();
    let id = format!("in use by process {}", std::process::id());
    Ran::gonio(dir.path(), &args).ends(1).says(&id);
    drop(lock);
    Ran::gonio(dir.path(), &args).ends(0);
}
