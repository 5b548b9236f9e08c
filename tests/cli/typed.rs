//! What is typed, and how commands end before any work is done.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::files::city;
use crate::ran::Ran;

/// A folder with a pipeline file `p.toml`, and inputs that are there but hold nothing.
fn folder() -> TempDir {
    let dir = TempDir::new().unwrap();
    let template = Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines/colmap.toml");
    fs::copy(template, dir.path().join("p.toml")).unwrap();
    for folder in ["images", "sparse/0"] {
        fs::create_dir_all(dir.path().join(folder)).unwrap();
    }
    for file in ["mesh.ply", "sparse/0/cameras.bin", "sparse/0/images.bin"] {
        fs::write(dir.path().join(file), "").unwrap();
    }
    dir
}

#[test]
fn a_good_file_is_called_good() {
    let dir = city();
    let ran = Ran::gonio(dir.path(), "check p.toml");
    assert!(ran.ends(0).stdout().ends_with("degrees\np.toml: no problems\n"), "{ran}");
}

#[test]
fn inputs_that_hold_nothing_are_told_of() {
    Ran::gonio(folder().path(), "check p.toml").ends(1).says("mesh.ply: does not begin with the line \"ply\"");
    let dir = city();
    fs::remove_dir_all(dir.path().join("images")).unwrap();
    fs::create_dir(dir.path().join("images")).unwrap();
    Ran::gonio(dir.path(), "check p.toml").ends(1).says("none of the 10 photographs can be read").says("and 7 more");
    Ran::gonio(dir.path(), "plan p.toml").says("none of the 10 photographs can be read");
    Ran::gonio(dir.path(), "run p.toml").ends(1).says("none of the 10 photographs could be read: frame_000.jpg");
}

#[test]
fn all_problems_of_a_file_are_shown_and_the_code_is_2() {
    let dir = folder();
    let file = dir.path().join("p.toml");
    let text = fs::read_to_string(&file).unwrap().replace("tile = 32", "tiel = 32").replace("fill = true", "fill = 1");
    fs::write(&file, text).unwrap();
    fs::remove_file(dir.path().join("mesh.ply")).unwrap();
    for command in ["check", "run", "export"] {
        let ran = Ran::gonio(dir.path(), &format!("{command} p.toml --set run.threads=many"));
        ran.ends(2).says("did you mean `tile`?").says("merge.fill: must be true or false; got 1");
        ran.says("scene.mesh: no such file; got mesh.ply")
            .says("--set run.threads: must be a whole number; got \"many\"");
        ran.says("4 problems");
        assert_eq!(ran.stdout(), "", "{ran}");
    }
}

#[test]
fn a_key_can_be_set_from_any_folder() {
    let dir = city();
    let other = TempDir::new().unwrap();
    fs::copy(dir.path().join("mesh.ply"), other.path().join("my.ply")).unwrap();
    let file = dir.path().join("p.toml").display().to_string();
    Ran::gonio(other.path(), &format!("check {file}")).ends(0);
    Ran::gonio(other.path(), &format!("check {file} --set scene.mesh=my.ply")).ends(0);
    Ran::gonio(dir.path(), "check p.toml --set scene.mesh=my.ply").ends(2).says("--set scene.mesh: no such file");
}

#[test]
fn what_is_typed_wrong_ends_with_2() {
    let dir = folder();
    Ran::gonio(dir.path(), "chekc p.toml").ends(2).says("check");
    Ran::gonio(dir.path(), "").ends(2).says("Usage");
    Ran::gonio(dir.path(), "run").ends(2).says("PIPELINE");
    Ran::gonio(dir.path(), "run p.toml --fast").ends(2).says("--fast");
    Ran::gonio(dir.path(), "maps p.toml --triangles 1,-2 --out m.npz").ends(2).says("-2");
    Ran::gonio(dir.path(), "maps p.toml --out m.npz").ends(2).says("--triangles");
    Ran::gonio(dir.path(), "check nowhere.toml").ends(2).says("nowhere.toml: cannot be read");
}

#[test]
fn help_and_version_end_with_0() {
    let dir = folder();
    Ran::gonio(dir.path(), "--version").ends(0).says(env!("CARGO_PKG_VERSION"));
    Ran::gonio(dir.path(), "--help").ends(0).says("Exit codes: 0 all done");
    Ran::gonio(dir.path(), "help run").ends(0).says("--set");
}

#[test]
fn what_breaks_ends_with_1_and_one_line() {
    let dir = folder();
    let ran = Ran::gonio(dir.path(), "run p.toml");
    ran.ends(1).says("gonio: ");
    assert_eq!((ran.stdout().as_str(), ran.stderr().lines().count()), ("", 1), "{ran}");
    let ran = Ran::gonio(dir.path(), "run p.toml --json");
    ran.ends(1).says("\"event\":\"failed\"");
}
