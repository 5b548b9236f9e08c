//! The threads of the process: how many there are, whose they are, and what happens where the system grants fewer.

use std::collections::BTreeMap;
use std::fs;
use std::process::{Command, Stdio};

use tempfile::TempDir;

use crate::files::{outputs, quick};
use crate::ran::Ran;

/// The most threads of each name that a command had at once, without the number at the end of a name.
fn threads(dir: &TempDir, command: &str) -> BTreeMap<String, usize> {
    let mut run = Command::new(env!("CARGO_BIN_EXE_gonio"));
    // Whoever asks rayon for its usual pool gets more threads than a machine has.
    run.current_dir(dir.path()).args(command.split_whitespace()).env("RAYON_NUM_THREADS", "999999");
    run.env("RTEN_NUM_THREADS", "999999").stdout(Stdio::null()).stderr(Stdio::null());
    let mut run = run.spawn().unwrap();
    let mut most = BTreeMap::new();
    let tasks = format!("/proc/{}/task", run.id());
    let status = loop {
        let mut now: BTreeMap<String, usize> = BTreeMap::new();
        for task in fs::read_dir(&tasks).into_iter().flatten().flatten() {
            if let Ok(name) = fs::read_to_string(task.path().join("comm")) {
                // Until it runs the command, the process has the name of this test's thread.
                let name = if name.starts_with("threads::") { "gonio" } else { name.trim() };
                let name = name.trim_end_matches(|c: char| c.is_ascii_digit() || c == '-').to_owned();
                *now.entry(name).or_default() += 1;
            }
        }
        let all = now.values().sum();
        now.insert("all".to_owned(), all);
        for (name, count) in now {
            let most = most.entry(name).or_default();
            *most = count.max(*most);
        }
        if let Some(status) = run.try_wait().unwrap() {
            break status;
        }
    };
    assert!(status.success(), "{command}: {status}");
    most
}

#[test]
fn no_thread_runs_beside_those_that_were_asked_for() {
    let dir = quick();
    let network = "--set infer.estimator=network --set infer.backend=embedded --set run.work=network";
    for (command, asked) in [
        ("run p.toml --set run.threads=1".to_owned(), 1),
        ("run p.toml --set run.threads=5 --set run.work=five".to_owned(), 5),
        (format!("run p.toml --set run.threads=3 {network}"), 3),
        ("explain p.toml --set run.threads=3".to_owned(), 3),
        ("plan p.toml --set run.threads=3".to_owned(), 3),
        ("export p.toml --set run.threads=3".to_owned(), 3),
        ("buffers p.toml --frame frame_003.jpg --out b.exr --set run.threads=3".to_owned(), 3),
        ("maps p.toml --triangles 5 --out m.npz --set run.threads=3".to_owned(), 3),
        ("render p.toml --frame frame_003.jpg --out r.png --set run.threads=3".to_owned(), 3),
        ("eval scene p.toml --truth truth/materials.npy --frames 1 --set run.threads=3".to_owned(), 3),
        ("eval images images images".to_owned(), 0),
    ] {
        let most = threads(&dir, &command);
        // At most two stages of many threads are at work at a time, or a stage and the engine that it asks.
        assert!(most["all"] <= 2 * asked + 8, "{command}: {most:?}");
        // A pool that rayon starts by itself has threads without names of their own.
        assert!(most["gonio"] <= asked + 8, "{command}: {most:?}");
        let known = [
            "all", "cast", "deadline", "decode", "frames", "gather", "gonio", "infer", "keep", "look", "progress",
            "rten", "shards", "share",
        ];
        assert!(most.keys().all(|name| known.contains(&name.as_str())), "{command}: {most:?}");
    }
}

#[test]
fn where_few_threads_are_granted_a_run_goes_on_or_says_so() {
    let dir = quick();
    let run = "run p.toml --set run.threads=4 --set gather.group=1";
    Ran::gonio(dir.path(), &format!("{run} --set run.work=whole")).ends(0);
    let whole = outputs(&dir.path().join("whole"));
    let mut codes = Vec::new();
    for count in [0u64, 1, 2, 3, 5, 6, 7, 9, 12] {
        // Each thread takes a GiB of addresses, and the process itself less than one.
        let script = format!(
            "ulimit -v {}; RUST_MIN_STACK={} \"$GONIO\" {run} --set run.work=w{count}",
            (1 + count) << 20,
            1u64 << 30
        );
        let ran = Ran::script(dir.path(), &script);
        match ran.code() {
            Some(0) => assert!(outputs(&dir.path().join(format!("w{count}"))) == whole, "{count}: {ran}"),
            Some(1) => _ = ran.says("gonio: cannot start thread").says("[run] threads"),
            code => panic!("{count}, {code:?}: {ran}"),
        }
        assert!(!ran.stderr().contains("panicked"), "{count}: {ran}");
        codes.push(ran.code());
    }
    assert_eq!((codes.first(), codes.last()), (Some(&Some(1)), Some(&Some(0))), "{codes:?}");
}
