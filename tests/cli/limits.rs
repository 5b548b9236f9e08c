//! Limits of the system on memory, on the size of files and on their number: each ends in words, and the run goes on from there
//! once the limit is gone.

use std::fs;

use crate::files::{outputs, quick};
use crate::ran::Ran;

#[test]
fn a_limit_on_the_size_of_files_ends_in_words() {
    let dir = quick();
    Ran::gonio(dir.path(), "run p.toml --set run.work=whole").ends(0);
    // In units of 512 bytes.
    for (limit, command) in [(100, "run p.toml"), (1, "run p.toml"), (20, "synth bins --count 1000 --out bins")] {
        let ran = Ran::script(dir.path(), &format!("ulimit -f {limit}; \"$GONIO\" {command}"));
        ran.ends(1).says("gonio: ").says("File too large");
    }
    Ran::gonio(dir.path(), "run p.toml").ends(0);
    assert!(outputs(&dir.path().join("work")) == outputs(&dir.path().join("whole")));
    let names = fs::read_dir(dir.path()).unwrap().flatten().map(|entry| entry.file_name().into_string().unwrap());
    assert!(names.into_iter().all(|name| name != "bins" && !name.contains("gonio-tmp")), "rubbish is left");
}

#[test]
fn a_limit_on_memory_ends_in_words() {
    let dir = quick();
    Ran::gonio(dir.path(), "run p.toml --set run.work=whole").ends(0);
    let mut refused = 0;
    // In MiB: from what the program itself hardly starts with to what the run needs.
    for limit in [35, 40, 45, 50, 55, 60, 70, 110, 150, 170, 180, 230, 400] {
        let script =
            format!("ulimit -v {}; unset RUST_BACKTRACE; \"$GONIO\" run p.toml --set run.work=w{limit}", limit << 10);
        let ran = Ran::script(dir.path(), &script);
        let said = ran.stderr();
        match ran.code() {
            Some(0 | 3) => {}
            Some(1) => {
                refused += 1;
                assert!(said.lines().last().is_some_and(|line| line.starts_with("gonio: ")), "{limit}: {ran}");
            }
            // The system's loader could not map the program: it never began.
            Some(127) if said.contains("shared librar") => {}
            code => panic!("{limit}, {code:?}: {ran}"),
        }
        assert!(!said.contains("stack backtrace") && !said.contains("panicked"), "{limit}: {ran}");
        Ran::gonio(dir.path(), &format!("run p.toml --set run.work=w{limit}")).ends(0);
        assert!(outputs(&dir.path().join(format!("w{limit}"))) == outputs(&dir.path().join("whole")), "{limit}");
    }
    assert!(refused > 0);
}

#[test]
fn a_limit_on_open_files_ends_in_words() {
    let dir = quick();
    let mut refused = 0;
    for limit in [4, 5, 6, 7, 8, 10, 20] {
        let run = format!("run p.toml --set run.work=w{limit}");
        let ran = Ran::script(dir.path(), &format!("ulimit -n {limit}; \"$GONIO\" {run}"));
        if ran.code() != Some(0) {
            refused += 1;
            ran.ends(1).says("Too many open files");
            Ran::gonio(dir.path(), &run).ends(0);
        }
    }
    assert!(refused > 0);
}
