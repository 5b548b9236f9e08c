//! Which way is up and where on the earth a scene lies: what the file says, what is found, what contradicts.

use std::fs;

use tempfile::TempDir;

use super::{TEMPLATE, load_text, scene};
use crate::pipeline::Pipeline;

/// A COLMAP model of a camera that looks straight down from a place: too little to tell the way up.
fn camera_at(dir: &TempDir, [x, y, z]: [f64; 3]) {
    for file in ["cameras.bin", "images.bin"] {
        fs::remove_file(dir.path().join("sparse/0").join(file)).unwrap_or_default();
    }
    fs::write(dir.path().join("sparse/0/cameras.txt"), "1 PINHOLE 40 40 50 50 20 20\n").unwrap();
    // The camera's x is the world's, its y and z are turned about: t = -R c.
    let pose = format!("1 0 1 0 0 {} {y} {z} 1 a.jpg\n\n", -x);
    fs::write(dir.path().join("sparse/0/images.txt"), pose).unwrap();
}

fn placed(dir: &TempDir, sets: &[&str]) -> (Option<String>, Option<[f64; 3]>, [f64; 3]) {
    let Pipeline { scene, .. } = load_text(dir, TEMPLATE.as_bytes(), sets).unwrap();
    (scene.crs.map(|crs| crs.to_string()), scene.offset, scene.up)
}

#[test]
fn what_the_file_says_counts_before_what_lies_beside_the_mesh() {
    let dir = scene();
    camera_at(&dir, [1.0, 2.0, 30.0]);
    let (utm, z) = (Some("EPSG:32633".to_owned()), [0.0, 0.0, 1.0]);
    assert_eq!(placed(&dir, &[]).0, None);
    assert_eq!(placed(&dir, &["scene.crs=32633", "scene.up=[0,-1,0]"]), (utm.clone(), None, [0.0, -1.0, 0.0]));
    let metadata = "<SRS>EPSG:32633</SRS><SRSOrigin>412000,5812000,7</SRSOrigin>";
    fs::write(dir.path().join("metadata.xml"), metadata).unwrap();
    let origin = Some([412_000.0, 5_812_000.0, 7.0]);
    assert_eq!(placed(&dir, &[]), (utm.clone(), origin, z));
    assert_eq!(placed(&dir, &["scene.up=[0,0,3]"]), (utm.clone(), origin, [0.0, 0.0, 3.0]));
    assert_eq!(placed(&dir, &["scene.crs=UTM 32N"]), (Some("EPSG:32632".to_owned()), origin, z));
    assert_eq!(placed(&dir, &["scene.offset=[1, 2.5, 3]"]), (utm, Some([1.0, 2.5, 3.0]), z));
}

#[test]
fn geocentric_coordinates_have_their_own_up_and_north() {
    let dir = scene();
    camera_at(&dir, [0.0, 6_378_200.0, 0.0]);
    let sets = ["scene.crs=EPSG:4978", "light.mode=ephemeris"];
    let pipeline = load_text(&dir, TEMPLATE.as_bytes(), &sets).unwrap();
    assert_eq!((pipeline.scene.up, pipeline.light.north), ([0.0, 1.0, 0.0], Some([0.0, 0.0, 1.0])));
    let given = [&sets[..], &["light.north=[1,0,0]"]].concat();
    assert_eq!(load_text(&dir, TEMPLATE.as_bytes(), &given).unwrap().light.north, Some([1.0, 0.0, 0.0]));
}

#[test]
fn what_is_no_system_of_metres_is_refused() {
    let dir = scene();
    for (set, words) in [
        ("scene.crs=nowhere", "as \"EPSG:32633\", a zone, as \"UTM 33N\", or a plane"),
        ("scene.crs=4326", "this system has degrees"),
        ("scene.crs=[1]", "must be a string"),
        ("scene.offset=[1, 2]", "must be a list of 3 numbers"),
        ("scene.offset=[1, 2, inf]", "must be three finite numbers"),
    ] {
        let why = load_text(&dir, TEMPLATE.as_bytes(), &[set]).unwrap_err();
        assert!(why.contains(words) && why.contains(set.split('=').next().unwrap()), "{why}");
    }
}
