//! Which of several poses, folders and meshes are taken.

use std::fs;

use super::folder::Folder;
use crate::before::{Found, text};

const SIZE: [u32; 2] = [40, 30];

/// The values of a key of the pipeline file.
fn value(folder: &Folder, key: &str) -> Option<String> {
    let text = text(&Found::at(folder.path()).unwrap());
    let line = text.lines().find_map(|line| line.strip_prefix(&format!("{key} = ")));
    line.map(|value| value.trim_matches('"').to_owned())
}

#[test]
fn poses_are_taken_whose_photographs_are_there_and_fit() {
    let folder = Folder::new().model("sparse/0", [60, 40], &["a.png"]).model("dense/sparse", SIZE, &["a.png"]);
    let undistorted = folder.picture("dense/images/a.png", SIZE);
    assert_eq!(value(&undistorted, "path").unwrap(), "dense/sparse");
    assert_eq!(value(&undistorted, "images").unwrap(), "dense/images");
    let both = undistorted.picture("images/a.png", [60, 40]);
    assert_eq!((value(&both, "path").unwrap(), value(&both, "images").unwrap()), ("sparse/0".into(), "images".into()));
    let more = both.model("sparse/1", [60, 40], &["a.png", "b.png"]).picture("images/b.png", [60, 40]);
    assert_eq!(value(&more, "path").unwrap(), "sparse/1");
}

#[test]
fn photographs_are_found_in_folders_of_any_name_and_under_names_that_are_alike() {
    let folder = Folder::new().model("0", SIZE, &["cam/a.png"]);
    assert_eq!(value(&folder.picture("photos/2024/cam/a.png", SIZE), "images").unwrap(), "photos/2024");
    let folder = Folder::new().model("0", SIZE, &["A.PNG"]).picture("masks/a.png", SIZE).picture("photos/a.png", SIZE);
    assert_eq!(value(&folder, "images").unwrap(), "photos");
    let lines = Found::at(folder.path()).unwrap().lines().join("\n");
    assert!(lines.contains("photos: 1 of 1, found without regard to upper and lower case"), "{lines}");
    assert_eq!(value(&folder, "masks"), Some("masks".into()));
    let smaller = Folder::new().model("0", SIZE, &["a.png"]).picture("images_2/a.png", [20, 15]);
    let smaller = smaller.picture("images_4/a.png", [10, 7]).picture("original/a.png", SIZE);
    assert_eq!(value(&smaller, "images").unwrap(), "original", "no downscale is better than one");
}

#[test]
fn the_largest_mesh_is_taken_that_nothing_was_taken_from() {
    let folder = Folder::new().mesh("a.ply", 1).mesh("b/b.ply", 30).mesh("simplified.ply", 90).cloud("points.ply");
    let folder = folder.with("cut.ply", "ply\nformat ascii 1.0\nelement vertex 3\n");
    assert_eq!(value(&folder, "mesh").unwrap(), "b/b.ply");
    let lines = Found::at(folder.path()).unwrap().lines().join("\n");
    assert!(lines.contains("there is also a.ply, simplified.ply"), "{lines}");
}

#[test]
fn hidden_folders_and_those_of_runs_are_not_looked_at() {
    let folder = Folder::new().mesh("a.ply", 1).mesh(".trash/b.ply", 9).mesh("work/export/scene.ply", 99);
    let folder = folder.with("work/gonio-run", "").model(".old/sparse", SIZE, &["a.png"]);
    assert_eq!(value(&folder, "mesh").unwrap(), "a.ply");
    assert_eq!(Found::at(folder.path()).unwrap().missing().len(), 1);
}

#[cfg(unix)]
#[test]
fn links_are_followed_and_lead_round_once() {
    let photographs = Folder::new().picture("a.png", SIZE);
    let folder = Folder::new().model("sparse/0", SIZE, &["a.png"]).mesh("a.ply", 1);
    std::os::unix::fs::symlink(photographs.path(), folder.path().join("images")).unwrap();
    std::os::unix::fs::symlink(folder.path(), folder.path().join("again")).unwrap();
    assert_eq!(value(&folder, "images").unwrap(), "images");
    assert_eq!(Found::at(folder.path()).unwrap().missing(), [""; 0]);
}

#[test]
fn poses_that_cannot_be_read_are_told() {
    let folder = Folder::new().model("sparse/0", SIZE, &["a.png"]).mesh("a.ply", 1);
    fs::write(folder.path().join("sparse/0/cameras.txt"), "1 PINHOLE 40\n").unwrap();
    let missing = Found::at(folder.path()).unwrap().missing().join("\n");
    assert!(missing.contains("poses sparse/0 cannot be read") && missing.contains("cameras.txt"), "{missing}");
}

#[test]
fn names_that_toml_has_another_word_for_come_back() {
    let folder = Folder::new().mesh("my \"best\" mesh.ply", 1);
    let text = text(&Found::at(folder.path()).unwrap());
    let read: toml::Table = text.parse().unwrap();
    assert_eq!(read["scene"]["mesh"].as_str(), Some("my \"best\" mesh.ply"));
}

#[test]
fn tiles_that_lie_beside_each_other_are_one_mesh_and_versions_of_one_are_not() {
    let model = || Folder::new().model("sparse/0", SIZE, &["a.png"]).picture("images/a.png", SIZE);
    let tile =
        |folder: Folder, at: i32| folder.ground(&format!("Data/Tile_+00{at}/Tile_+00{at}.obj"), f64::from(at) * 55.0);
    let tiled = (0..3).fold(model(), tile).ground("overview.obj", 55.0);
    assert_eq!(value(&tiled, "mesh").unwrap(), "Data/Tile_*/Tile_*.obj");
    let lines = Found::at(tiled.path()).unwrap().lines().join("\n");
    assert!(
        lines.contains("Data/Tile_*/Tile_*.obj, 3 files, ") && lines.contains("there is also overview.obj"),
        "{lines}"
    );
    let versions = model().ground("v1/mesh_1.ply", 0.0).ground("v1/mesh_2.ply", 5.0);
    assert_eq!(value(&versions, "mesh").unwrap(), "v1/mesh_1.ply");
    let constant = model().ground("v1/t_1.ply", 0.0).ground("v1/t_2.ply", 60.0);
    assert_eq!(value(&constant, "mesh").unwrap(), "v1/t_*.ply");
}
