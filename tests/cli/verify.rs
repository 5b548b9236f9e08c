//! `gonio verify`: what it says and how it ends.

use std::fs;
use std::path::Path;

use tempfile::TempDir;

use crate::files::{city, outputs};
use crate::ran::Ran;

fn gonio(dir: &TempDir, args: &str) -> Ran {
    Ran::gonio(dir.path(), args)
}

fn flip(file: &Path) {
    let mut bytes = fs::read(file).unwrap();
    let middle = bytes.len() / 2;
    bytes[middle] ^= 1;
    fs::write(file, bytes).unwrap();
}

#[test]
fn a_run_is_sound_until_something_rots_and_again_after_the_next_run() {
    let dir = city();
    gonio(&dir, "verify p.toml").ends(1).says("holds no run: `gonio run p.toml` makes one");
    gonio(&dir, "run p.toml").ends(0);
    let said = gonio(&dir, "verify p.toml --inputs");
    said.ends(0).says("all as they were written; the inputs are those that they were made of");
    assert_eq!(said.stdout().lines().count(), 1, "{said}");
    let work = dir.path().join("work/p");
    let expected = outputs(&work);
    flip(&work.join("export/scene.ply"));
    flip(&work.join("materials.npy"));
    let said = gonio(&dir, "verify p.toml");
    said.ends(1)
        .says("scene.ply (export ply): ")
        .says("materials.npy (merge): ")
        .says("2 rotten: `gonio run p.toml --set run.verify=true`");
    // Nothing was changed by looking.
    gonio(&dir, "verify p.toml").ends(1).says("2 rotten");
    gonio(&dir, "run p.toml").ends(0).says("corrupt/scene.ply").says("corrupt/materials.npy");
    assert!(outputs(&work) == expected);
    gonio(&dir, "verify p.toml").ends(0);
    // Other exports, made without a run, belong to it.
    gonio(&dir, "export p.toml --set export.formats=[\"glb\"]").ends(0);
    gonio(&dir, "verify p.toml").ends(0).says("all as they were written");
}

#[test]
fn what_is_set_is_what_is_verified_and_a_run_that_broke_off_is_too() {
    let dir = city();
    let image = dir.path().join("images/frame_004.jpg");
    gonio(&dir, "run p.toml --set run.work=other --set export.formats=[]").ends(0);
    gonio(&dir, "verify p.toml").ends(1);
    gonio(&dir, "verify p.toml --set run.work=other --inputs").ends(0);
    flip(&image);
    gonio(&dir, "verify p.toml --set run.work=other").ends(0);
    let said = gonio(&dir, "verify p.toml --set run.work=other --inputs");
    said.ends(1).says("frame_004.jpg (look 0): the image of frame_004.jpg changed").says("1 changed: put it back");
    fs::remove_file(dir.path().join("other/report.json")).unwrap();
    gonio(&dir, "verify p.toml --set run.work=other")
        .ends(0)
        .says("not finished: `gonio run p.toml` goes on from here");
}
