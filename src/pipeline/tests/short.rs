//! The shortest pipeline file: a mesh, images, poses.

use std::fs;

use super::{load_text, scene};
use crate::codec::poses::COLMAP;

const SHORT: &str = "[scene]\nmesh = \"mesh.ply\"\nimages = \"images\"\nposes = \"sparse/0\"\n";

#[test]
fn three_lines_are_a_pipeline() {
    let dir = scene();
    let at = |name: &str| dir.path().join(name);
    let short = load_text(&dir, SHORT.as_bytes(), &[]).unwrap();
    assert_eq!((short.scene.poses.format, &short.scene.poses.path), (&COLMAP, &at("sparse/0")));
    assert_eq!(short.run.work, at("work/p"));
    let long =
        SHORT.replace("\"sparse/0\"", "{ format = \"colmap\", path = \"sparse/0\" }") + "[run]\nwork = \"work/p\"\n";
    assert_eq!(short, load_text(&dir, long.as_bytes(), &[]).unwrap());
    let bad = load_text(&dir, SHORT.as_bytes(), &["run.work="]).unwrap_err();
    assert!(bad.contains("--set run.work: must be a path") && bad.lines().count() == 1, "{bad}");
    // No input lies where a run removes what it needs no more.
    fs::create_dir_all(at("work/p/images")).unwrap();
    let within = load_text(&dir, SHORT.replace("\"images\"", "\"work/p/images\"").as_bytes(), &[]).unwrap_err();
    assert!(within.contains("scene.images: must not lie in the folder of [run] work"), "{within}");
}

#[test]
fn the_format_of_poses_is_told_by_their_files_or_asked_for() {
    let dir = scene();
    let load = |poses: &str| load_text(&dir, SHORT.replace("sparse/0", poses).as_bytes(), &[]);
    fs::create_dir(dir.path().join("odm")).unwrap();
    fs::write(dir.path().join("odm/reconstruction.json"), "[{\"cameras\": {}, \"shots\": {}}]").unwrap();
    assert_eq!(load("odm").unwrap().scene.poses.format.name, "opensfm");
    assert_eq!(load("odm/reconstruction.json").unwrap().scene.poses.format.name, "opensfm");
    fs::write(dir.path().join("odm/cameras.txt"), "").unwrap();
    fs::write(dir.path().join("odm/images.txt"), "").unwrap();
    for (poses, words) in [
        ("odm", "scene.poses.path: may be colmap or opensfm"),
        ("odm", "say which: poses = { format = \"colmap\", path = .. }"),
        ("images", "scene.poses.path: holds no poses that are known by their files"),
        ("images", "say which: poses = { format = one of colmap, opendronemap"),
        ("nowhere", "scene.poses.path: no such file or folder"),
        ("", "scene.poses.path: must be a path"),
    ] {
        let why = load(poses).unwrap_err();
        assert!(why.contains(words) && why.contains("p.toml:4:") && why.lines().count() == 1, "{why}");
    }
    let none = load_text(&dir, SHORT.replace("\"sparse/0\"", "3").as_bytes(), &[]).unwrap_err();
    assert!(none.contains("must be a table of keys; got 3"), "{none}");
}

#[test]
fn a_mesh_may_be_a_list() {
    let dir = scene();
    fs::write(dir.path().join("b.obj"), "").unwrap();
    let load = |mesh: &str| load_text(&dir, SHORT.replace("\"mesh.ply\"", mesh).as_bytes(), &[]);
    let files = load("[\"mesh.ply\", \"*.obj\"]").unwrap().scene.mesh.files().unwrap();
    assert_eq!(files, ["mesh.ply", "b.obj"].map(|name| dir.path().join(name)));
    for (mesh, words) in [
        ("[]", "scene.mesh: must be a path, or a list of paths"),
        ("[\"mesh.ply\", 3]", "scene.mesh: must be a string"),
        ("[\"mesh.ply\", \"c.obj\"]", "scene.mesh: no such file; got c.obj"),
        ("[\"mesh.ply\", \"*.stl\"]", "scene.mesh: no file fits"),
    ] {
        let why = load(mesh).unwrap_err();
        assert!(why.contains(words) && why.contains("p.toml:2:8"), "{why}");
    }
}
