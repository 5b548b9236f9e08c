//! `gonio init`: from a project's folder to materials, in two commands.

use std::fs;

use image::imageops::FilterType;
use tempfile::TempDir;

use crate::files::{city, outputs, quick};
use crate::ran::Ran;

/// What makes a run quick, as in the hand-written file.
const SETS: &str = "--set gather.group=2 --set infer.estimator=fit --set light.mode=known \
                    --set light.sun=[-0.456,-0.507,0.731] --set run.memory=1GiB --set run.threads=2";

#[test]
fn two_commands_give_the_materials_of_the_hand_written_file() {
    let dir = quick();
    let folder = dir.path();
    Ran::gonio(folder, "init .").ends(0).says("sparse/0: colmap").says("images: 10 of 10").says("wrote ./gonio.toml");
    let written = fs::read(folder.join("gonio.toml")).unwrap();
    Ran::gonio(folder, "check .").ends(0).says("no problems");
    Ran::gonio(folder, &format!("run . {SETS}")).ends(0);
    Ran::gonio(folder, "run p.toml --set scene.up=[0,0,1]").ends(0);
    assert_eq!(outputs(&folder.join("gonio"))[..1], outputs(&folder.join("work"))[..1]);
    // What a run left is not taken for a part of the project, and the file is never overwritten.
    Ran::gonio(folder, "init .").ends(1).says("never overwritten");
    assert_eq!(fs::read(folder.join("gonio.toml")).unwrap(), written);
    let again = Ran::gonio(folder, "init . --print");
    assert_eq!(again.ends(0).stdout().as_bytes(), written, "{again}");
}

#[test]
fn three_lines_give_the_materials_of_the_whole_file() {
    let dir = quick();
    let folder = dir.path();
    fs::write(folder.join("short.toml"), "[scene]\nmesh = [\"mesh.ply\"]\nimages = \"images\"\nposes = \"sparse/0\"\n")
        .unwrap();
    Ran::gonio(folder, &format!("run short.toml {SETS}")).ends(0).says("results        work/short: export/scene.glb");
    Ran::gonio(folder, "run p.toml --set scene.up=[0,0,1] --set run.work=by-hand").ends(0);
    assert_eq!(outputs(&folder.join("work/short"))[..1], outputs(&folder.join("by-hand"))[..1]);
}

#[test]
fn print_writes_nothing() {
    let dir = city();
    let names = || {
        let mut names: Vec<_> = fs::read_dir(dir.path()).unwrap().map(|entry| entry.unwrap().file_name()).collect();
        names.sort();
        names
    };
    let before = names();
    let ran = Ran::gonio(dir.path(), "init . --print");
    ran.ends(0);
    assert!(ran.stdout().contains("\nmesh = \"mesh.ply\"\n") && ran.stderr().contains("images: 10 of 10"), "{ran}");
    assert_eq!(names(), before);
}

#[test]
fn a_folder_without_a_pipeline_file_names_init() {
    let dir = city();
    for command in ["run", "check", "plan", "explain"] {
        let ran = Ran::gonio(dir.path(), &format!("{command} ."));
        ran.ends(2)
            .says("is a folder without a pipeline file, which would be gonio.toml")
            .says("gonio init . writes one");
    }
    let empty = TempDir::new().unwrap();
    Ran::gonio(empty.path(), "init .").ends(1).says("holds neither poses nor photographs nor a mesh");
    assert_eq!(fs::read_dir(empty.path()).unwrap().count(), 0);
}

#[test]
fn what_is_missing_is_named_and_the_file_is_good_once_it_is_there() {
    let dir = city();
    let at = |name: &str| dir.path().join(name);
    fs::rename(at("mesh.ply"), at("made.tmp")).unwrap();
    Ran::gonio(dir.path(), "init .").ends(3).says("missing: the mesh").says("colmap poisson_mesher");
    Ran::gonio(dir.path(), "check .").ends(2).says("dense/meshed-poisson.ply");
    fs::create_dir(at("dense")).unwrap();
    fs::rename(at("made.tmp"), at("dense/meshed-poisson.ply")).unwrap();
    Ran::gonio(dir.path(), "check .").ends(0).says("no problems");
}

#[test]
fn half_size_photographs_are_read_at_once() {
    let dir = city();
    for entry in fs::read_dir(dir.path().join("images")).unwrap() {
        let path = entry.unwrap().path();
        image::open(&path).unwrap().resize_exact(80, 60, FilterType::Triangle).save(&path).unwrap();
    }
    Ran::gonio(dir.path(), "init .").ends(0).says("2 times smaller than the cameras");
    Ran::gonio(dir.path(), "check .").ends(0).says("no problems");
}

#[test]
fn shells_and_man_know_the_command_line() {
    let dir = TempDir::new().unwrap();
    for (shell, word) in [("bash", "complete -F _gonio"), ("zsh", "#compdef gonio"), ("fish", "complete -c gonio")] {
        Ran::gonio(dir.path(), &format!("completions {shell}")).ends(0).says(word).says("init");
    }
    Ran::gonio(dir.path(), "completions dos").ends(2);
    Ran::gonio(dir.path(), "man").ends(0).says(".TH gonio 1").says("gonio\\-init(1)");
    Ran::gonio(dir.path(), "man --out pages").ends(0);
    for page in ["gonio.1", "gonio-init.1", "gonio-run.1"] {
        assert!(fs::read_to_string(dir.path().join("pages").join(page)).unwrap().contains(".TH"), "{page}");
    }
}
