//! Maps of spheres and lobes against the formulas in float64, which numpy works out anew. `GONIO_PYTHON` names a Python that
//! has it; where there is none the test says so.

use std::path::Path;
use std::process::Command;

use crate::ran::Ran;

/// A Python with numpy.
fn python() -> Option<String> {
    let python = std::env::var("GONIO_PYTHON").unwrap_or_else(|_| "python3".into());
    let there = Command::new(&python).args(["-c", "import numpy"]).output().is_ok_and(|o| o.status.success());
    if !there {
        println!("skipped: {python} has no numpy");
    }
    there.then_some(python)
}

#[test]
fn maps_are_those_of_the_formulas_in_float64() {
    let Some(python) = python() else { return };
    let dir = tempfile::tempdir().unwrap();
    let cases = [
        ("lobe", "--kind lobe"),
        ("orthographic", "--kind sphere"),
        ("perspective", "--kind sphere --camera perspective"),
    ];
    for (kind, options) in cases {
        Ran::gonio(dir.path(), &format!("synth spheres {options} --count 100 --seed 5 --out {kind}")).ends(0);
        let judge = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/cli/spheres.py");
        let judged = Command::new(&python).arg(judge).arg(dir.path().join(kind)).arg(kind).output().unwrap();
        println!("{kind}: {}", String::from_utf8_lossy(&judged.stdout));
        assert!(judged.status.success(), "{kind}: {}", String::from_utf8_lossy(&judged.stderr));
    }
}
