//! What becomes of a command whose standard output or standard error is full, closed, or has no reader.

use tempfile::TempDir;

use crate::files::quick;
use crate::ran::Ran;

/// The commands whose result is what they write, on a run that is finished.
const COMMANDS: [&str; 16] = [
    "--version",
    "--help",
    "help run",
    "run --help",
    "check p.toml",
    "plan p.toml",
    "explain p.toml",
    "export p.toml",
    "run p.toml",
    "run p.toml --json",
    "eval images images/frame_001.jpg images/frame_002.jpg",
    "eval images --json images/frame_001.jpg images/frame_002.jpg",
    "eval materials truth/materials.npy work/materials.npy",
    "eval scene p.toml --truth truth/materials.npy --frames 1 --json",
    "synth city --out made --triangles 5000 --frames 1 --width 16 --height 16",
    "synth bins --count 10 --out -",
];

fn finished() -> TempDir {
    let dir = quick();
    Ran::gonio(dir.path(), "run p.toml").ends(0);
    dir
}

#[test]
fn output_that_cannot_be_written_is_told_and_ends_with_1() {
    let dir = finished();
    for command in COMMANDS {
        for (to, why) in [
            (">/dev/full", "No space left on device"),
            (">&-", "it is closed"),
            ("1</dev/null", "not open for writing"),
        ] {
            let ran = Ran::script(dir.path(), &format!("\"$GONIO\" {command} {to}"));
            ran.ends(1).says("cannot write standard output: ").says(why);
        }
    }
    let ran = Ran::script(dir.path(), "\"$GONIO\" run p.toml >&-");
    ran.ends(1).says("the run is done, and work has its results");
    // Neither stream is there: nothing can be said, and the code says it.
    Ran::script(dir.path(), "\"$GONIO\" plan p.toml >&- 2>&-").ends(1);
    Ran::script(dir.path(), "\"$GONIO\" plan p.toml >/dev/full 2>/dev/full").ends(1);
}

#[test]
fn a_reader_that_left_changes_nothing() {
    let dir = finished();
    for command in COMMANDS {
        // The reader is gone before the command begins.
        let script = format!("{{ sleep 0.05; \"$GONIO\" {command}; echo \"code $?\" >&2; }} | true");
        let ran = Ran::script(dir.path(), &script);
        assert_eq!(ran.stderr().lines().last(), Some("code 0"), "{ran}");
        assert!(!ran.stderr().contains("standard output"), "{ran}");
    }
}

#[test]
fn standard_error_that_cannot_be_written_changes_nothing() {
    let dir = finished();
    for (command, code) in [
        ("run p.toml", 0),
        ("run p.toml --json", 0),
        ("check p.toml --set cast.tile=33", 2),
        ("run p.toml --fast", 2),
        ("eval materials truth/materials.npy nowhere.npy", 1),
        ("run p.toml --set run.memory=20MiB --set run.work=other", 1),
    ] {
        let usual = Ran::gonio(dir.path(), command);
        for to in ["2>/dev/full", "2>&-"] {
            let ran = Ran::script(dir.path(), &format!("\"$GONIO\" {command} {to}"));
            ran.ends(code);
            assert_eq!(ran.stdout().lines().count(), usual.stdout().lines().count(), "{ran}{usual}");
        }
    }
}

#[test]
fn a_slow_reader_that_does_not_let_writers_wait_gets_all() {
    let dir = quick();
    // The pipe is full, and writers are told so, until the reader wakes up.
    let script = "python3 -c 'import fcntl, os, subprocess, time
r, w = os.pipe()
fcntl.fcntl(w, fcntl.F_SETFL, os.O_NONBLOCK)
made = subprocess.Popen([os.environ[\"GONIO\"], \"synth\", \"bins\", \"--count\", \"1000\", \"--out\", \"-\"], stdout=w)
os.close(w)
time.sleep(0.5)
print(len(b\"\".join(iter(lambda: os.read(r, 65536), b\"\"))), made.wait())'";
    if !std::process::Command::new("python3").arg("--version").output().is_ok_and(|ran| ran.status.success()) {
        return println!("skipped: no python3 to make such a pipe");
    }
    Ran::gonio(dir.path(), "synth bins --count 1000 --out whole").ends(0);
    let whole = std::fs::metadata(dir.path().join("whole")).unwrap().len();
    let ran = Ran::script(dir.path(), script);
    assert_eq!(ran.stdout(), format!("{whole} 0\n"), "{ran}");
}
