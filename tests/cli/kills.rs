//! Runs that are killed: whenever it happens, the same command goes on, and the same bytes come out.

use std::fs;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use tempfile::TempDir;

use crate::files::{city, outputs, pipelines};
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

/// Kills runs at random instants of the time that a whole one takes, each going on where the one before was killed, until
/// one ends; and so on, `kills` times in all. Every run that ends has the bytes of the whole one. `args` are for the folder
/// of that name, and `clear` is told which round begins.
fn killed_and_resumed(dir: &TempDir, args: impl Fn(&str) -> String, kills: usize, clear: &dyn Fn(usize)) {
    let started = Instant::now();
    Ran::gonio(dir.path(), &args("whole")).ends(0);
    let whole = started.elapsed();
    let expected = outputs(&dir.path().join("whole"));
    let (args, work) = (args("killed"), dir.path().join("killed"));
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let mut done = 0;
    for round in 0.. {
        if done >= kills {
            break;
        }
        fs::remove_dir_all(&work).unwrap_or_default();
        clear(round);
        loop {
            let mut run = start(dir, &args);
            sleep(whole.mul_f64(random.random_range(0.0..1.1)));
            if let Some(status) = run.try_wait().unwrap() {
                assert!(status.success(), "after {done} kills a run ended by itself: {status}");
                break;
            }
            run.kill().unwrap();
            run.wait().unwrap();
            done += 1;
            if done >= kills {
                break;
            }
        }
        Ran::gonio(dir.path(), &args).ends(0);
        assert!(outputs(&work) == expected, "after {done} kills");
        let left = fs::read_dir(work.join("segments")).unwrap().chain(fs::read_dir(&work).unwrap());
        assert!(left.flatten().all(|e| !e.file_name().to_string_lossy().contains("gonio-tmp")), "rubbish is left");
    }
}

fn kill(kills: usize) {
    let dir = scene();
    killed_and_resumed(&dir, |work| format!("run p.toml {SETS} --set run.work={work}"), kills, &|_| ());
}

fn kills() -> usize {
    std::env::var("GONIO_KILLS").map_or(200, |n| n.parse().unwrap())
}

#[test]
fn a_run_that_is_killed_goes_on_to_the_same_bytes() {
    kill(6);
}

/// As many as `GONIO_KILLS` says, else 200.
#[test]
#[ignore = "minutes; .ci/run runs it"]
fn a_run_that_is_killed_often_goes_on_to_the_same_bytes() {
    kill(kills());
}

/// The demo killed; every other time its city is made again too. `sets` are further settings.
fn kill_demo(kills: usize, sets: &str) {
    let dir = TempDir::new().unwrap();
    fs::copy(pipelines().join("demo.toml"), dir.path().join("p.toml")).unwrap();
    let args = |work: &str| format!("run p.toml --set run.work={work} {sets}");
    Ran::gonio(dir.path(), &args("first")).ends(0);
    let city = dir.path().join("work/city");
    killed_and_resumed(&dir, args, kills, &|round| {
        if round % 2 == 0 {
            fs::remove_dir_all(&city).unwrap();
        }
    });
}

#[test]
fn a_run_that_is_killed_while_it_makes_its_city_goes_on_to_the_same_bytes() {
    let city = "triangles=5000 frames=6 width=96 height=72 supersampling=1";
    let sets: String = city.split(' ').map(|set| format!("--set synth.city.{set} ")).collect();
    kill_demo(5, &sets);
}

/// As many as `GONIO_KILLS` says, else 200.
#[test]
#[ignore = "an hour; for a release build"]
fn the_demo_that_is_killed_often_goes_on_to_the_same_bytes() {
    kill_demo(kills(), "--set gather.group=4");
}

/// The cache is the first thing that a run makes; nothing but the kill keeps it from being made in a moment.
#[test]
fn a_run_that_is_killed_while_it_makes_the_scene_cache_goes_on_to_the_same_bytes() {
    let dir = scene();
    let args = |work: &str| format!("run p.toml {SETS} --set run.work={work}");
    Ran::gonio(dir.path(), &args("whole")).ends(0);
    let (work, whole) = (dir.path().join("work"), dir.path().join("whole"));
    let caches = |work: &Path| {
        let entries = fs::read_dir(work.join("scene")).into_iter().flatten().flatten();
        entries.map(|e| e.file_name().into_string().unwrap()).collect::<Vec<_>>()
    };
    let killed = (0..40).any(|_| {
        fs::remove_dir_all(&work).unwrap_or_default();
        let mut run = start(&dir, &args("work"));
        while caches(&work).is_empty() && run.try_wait().unwrap().is_none() {}
        run.kill().unwrap();
        run.wait().unwrap();
        caches(&work).iter().any(|name| name.contains("gonio-tmp"))
    });
    assert!(killed, "no run was killed while it made the cache");
    Ran::gonio(dir.path(), &args("work")).ends(0);
    assert!(outputs(&work) == outputs(&whole));
    assert!(caches(&work).iter().all(|name| !name.contains("gonio-tmp")), "rubbish is left");
    let cache = |work: &Path| fs::read(work.join("scene").join(&caches(work)[0])).unwrap();
    assert!(cache(&work) == cache(&whole));
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
        // As soon as a unit is done: in the midst of the work.
        let seen = |work: &Path| fs::read_dir(work.join("units")).map_or(0, Iterator::count);
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
    let store = gonio::internals::disk::DirStore::new(dir.path().join("work"));
    let lock = gonio::internals::disk::Lock::acquire(&store).unwrap();
    let id = format!("in use by process {}", std::process::id());
    Ran::gonio(dir.path(), &args).ends(1).says(&id);
    drop(lock);
    Ran::gonio(dir.path(), &args).ends(0);
}
