//! Files of the programs themselves, in `shared/formats` beside the checkout (or where GONIO_SHARED says). Each reader is held to
//! what its file says in another way: points that it reprojects, projections that it lists, GPS, the same photographs in
//! another format.

use std::fs;
use std::path::{Path, PathBuf};

use glam::{DVec2, DVec3};

use super::look;
use crate::base::Result;
use crate::codec::images::Size;
use crate::codec::poses::{COLMAP, FORMATS, NoPhotographs, Photographs, Posed, formats_at};
use crate::scene::frame::Frame;

/// A folder of files of others; `None`, said so, where it is not there.
fn shared(below: &str) -> Option<PathBuf> {
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared");
    let folder = std::env::var_os("GONIO_SHARED").map_or(beside, PathBuf::from).join(below);
    if folder.exists() {
        return Some(folder);
    }
    println!("skipped: {} is not there", folder.display());
    None
}

/// Photographs of one size.
struct Sized(Size);

impl Photographs for Sized {
    fn names(&self) -> Result<&[String]> {
        Ok(&[])
    }

    fn size(&self, _: &str) -> Result<Size> {
        Ok(self.0)
    }
}

fn read(format: &str, path: &Path, photographs: &dyn Photographs) -> Posed {
    let format = FORMATS.iter().find(|one| one.name == format).unwrap();
    look(format, path, photographs).unwrap()
}

fn median(mut all: Vec<f64>) -> f64 {
    all.sort_by(f64::total_cmp);
    all[all.len() / 2]
}

/// How far a frame sees a point from where the file saw it, from the centre of the image.
fn off(frame: &Frame, point: DVec3, seen: DVec2) -> Option<f64> {
    let size = DVec2::new(frame.camera.width.into(), frame.camera.height.into());
    Some(frame.camera.project(frame.pose.to_camera(point))?.distance(seen + size * 0.5))
}

#[test]
fn bundler_reprojects_its_own_points() {
    let Some(file) = shared("formats/bundler/bundle.out") else { return };
    let folder = tempfile::tempdir().unwrap();
    fs::copy(&file, folder.path().join("bundle.out")).unwrap();
    fs::write(folder.path().join("list.txt"), "a.jpg\nb.jpg\nc.jpg\nd.jpg\ne.jpg\n").unwrap();
    let frames = read("bundler", folder.path(), &Sized(Size { width: 3000, height: 2000 })).frames;
    let text = fs::read_to_string(&file).unwrap();
    let points: Vec<&str> = text.lines().skip(2 + 5 * frames.len()).collect();
    let numbers = |line: &str| line.split_whitespace().map(|word| word.parse().unwrap()).collect::<Vec<f64>>();
    let mut all = Vec::new();
    for point in points.chunks_exact(3) {
        let (at, views) = (DVec3::from_slice(&numbers(point[0])), numbers(point[2]));
        for view in views[1..].chunks_exact(4) {
            // The file's y leads up.
            all.extend(off(&frames[view[0] as usize], at, DVec2::new(view[2], -view[3])));
        }
    }
    let median = median(all);
    assert!(frames.len() == 5 && median < 0.5, "{median} pixels");
}

#[test]
fn visualsfm_reprojects_its_own_points_and_turns_as_colmap_does() {
    let Some(file) = shared("formats/nvm/sceaux.nvm") else { return };
    let posed = read("nvm", &file, &Sized(Size { width: 2832, height: 2128 }));
    let text = fs::read_to_string(&file).unwrap();
    let lines: Vec<&str> = text.lines().map(str::trim).filter(|line| !line.is_empty()).collect();
    // The order of the file, not of the names.
    let order: Vec<&str> = lines[2..13].iter().map(|line| line.split_whitespace().next().unwrap()).collect();
    let mut all = Vec::new();
    for line in &lines[14..314] {
        let n: Vec<f64> = line.split_whitespace().map(|word| word.parse().unwrap()).collect();
        for view in n[7..].chunks_exact(4) {
            let name = order[view[0] as usize].trim_start_matches("images/");
            let frame = posed.frames.iter().find(|frame| frame.name == name).unwrap();
            // This file counts from the corner.
            let half = DVec2::new(1416.0, 1064.0);
            all.extend(off(frame, DVec3::from_slice(&n), DVec2::new(view[2], view[3]) - half));
        }
    }
    let median = median(all);
    assert!(posed.frames.len() == 11 && median < 1.0, "{median} pixels");
    turns_as_colmap(&posed.frames, 0.05);
}

#[test]
fn opensfm_turns_as_colmap_does() {
    let Some(folder) = shared("formats/opensfm") else { return };
    turns_as_colmap(&read("opensfm", &folder.join("sceaux_meshed.json"), &NoPhotographs).frames, 0.3);
    if let Some(nvm) = shared("formats/nvm/sceaux.nvm") {
        // Two programs that were run apart: their cameras differ by half a degree at the end of the row.
        let visual = read("nvm", &nvm, &Sized(Size { width: 2832, height: 2128 })).frames;
        turn_alike(&read("opensfm", &folder.join("sceaux_meshed.json"), &NoPhotographs).frames, &visual, 1.0);
    }
    // The poses of shots and of rigs in one file are the same.
    let berlin = fs::read_to_string(folder.join("berlin_reconstruction.json")).unwrap();
    let bare = tempfile::tempdir().unwrap();
    let mut all: serde_json::Value = serde_json::from_str(&berlin).unwrap();
    for shot in all[0]["shots"].as_object_mut().unwrap().values_mut() {
        shot.as_object_mut().unwrap().remove("rotation");
    }
    fs::write(bare.path().join("reconstruction.json"), all.to_string()).unwrap();
    let (with, without) = (
        read("opensfm", &folder.join("berlin_reconstruction.json"), &NoPhotographs),
        read("opensfm", bare.path(), &NoPhotographs),
    );
    for (a, b) in with.frames.iter().zip(&without.frames) {
        assert!(
            a.pose.centre().distance(b.pose.centre()) < 1e-9
                && a.pose.rotation.dot(b.pose.rotation).abs() > 1.0 - 1e-12
        );
    }
    assert_eq!((with.frames.len(), without.frames.len()), (3, 3));
}

/// Relative rotations are those of COLMAP's model of the same photographs.
fn turns_as_colmap(frames: &[Frame], most: f64) {
    let Some(model) = shared("data/sceaux").and_then(|folder| {
        ["sparse/0", "sparse", "."].iter().map(|below| folder.join(below)).find(|model| (COLMAP.is_at)(model))
    }) else {
        println!("skipped: COLMAP's model of sceaux is not there");
        return;
    };
    let colmap = look(&COLMAP, &model, &NoPhotographs).unwrap().frames;
    turn_alike(frames, &colmap, most);
}

/// Two formats turn the same photographs alike, from each to the next, within so many degrees.
fn turn_alike(frames: &[Frame], colmap: &[Frame], most: f64) {
    let last = |name: &str| name.rsplit('/').next().unwrap_or_default().to_lowercase();
    let pairs: Vec<(&Frame, &Frame)> =
        frames.iter().filter_map(|a| Some((a, colmap.iter().find(|b| last(&b.name) == last(&a.name))?))).collect();
    assert!(pairs.len() > 5, "{} photographs are in both", pairs.len());
    for pair in pairs.windows(2) {
        let turn = |a: &Frame, b: &Frame| a.pose.rotation * b.pose.rotation.inverse();
        let degrees = turn(pair[0].0, pair[1].0).angle_between(turn(pair[0].1, pair[1].1)).to_degrees();
        assert!(degrees < most, "{}: {degrees} degrees", pair[0].0.name);
    }
}

#[test]
fn micmac_sees_its_own_check_where_the_file_says() {
    let Some(folder) = shared("formats/micmac/Ori-Ground_mm3d") else { return };
    let frames = read("micmac", &folder, &NoPhotographs).frames;
    let mut worst = 0.0f64;
    for frame in &frames {
        let text = fs::read_to_string(folder.join(format!("Orientation-{}.xml", frame.name))).unwrap();
        let document = roxmltree::Document::parse(&text).unwrap();
        let numbers = |node: roxmltree::Node<'_, '_>, name: &str| -> Vec<f64> {
            let child = node.children().find(|child| child.has_tag_name(name)).unwrap();
            child.text().unwrap().split_whitespace().map(|word| word.parse().unwrap()).collect()
        };
        for check in document.descendants().filter(|node| node.has_tag_name("Appuis")) {
            let (seen, at) = (DVec2::from_slice(&numbers(check, "Im")), DVec3::from_slice(&numbers(check, "Ter")));
            worst = worst.max(frame.camera.project(frame.pose.to_camera(at)).unwrap().distance(seen));
        }
    }
    assert!(frames.len() == 3 && worst > 0.0 && worst < 1e-3, "{worst} pixels");
}

/// Geocentric coordinates of latitude, longitude (degrees) and height on the ellipsoid of WGS 84.
fn geocentric(longitude: f64, latitude: f64, height: f64) -> DVec3 {
    let (a, e2) = (6_378_137.0, 6.694_379_990_14e-3);
    let ((sin, cos), (east, north)) = (latitude.to_radians().sin_cos(), longitude.to_radians().sin_cos());
    let n = a / (1.0f64 - e2 * sin * sin).sqrt();
    DVec3::new((n + height) * cos * north, (n + height) * cos * east, (n * (1.0 - e2) + height) * sin)
}

#[test]
fn metashape_stands_where_its_gps_says() {
    let Some(file) = shared("formats/metashape/forest_ecef.xml") else { return };
    let posed = read("metashape", &file, &NoPhotographs);
    let text = fs::read_to_string(&file).unwrap();
    let document = roxmltree::Document::parse(&text).unwrap();
    let mut all = Vec::new();
    for camera in document.descendants().filter(|node| node.has_tag_name("camera")) {
        let label = camera.attribute("label").unwrap();
        let frame = posed.frames.iter().find(|frame| frame.name == label);
        let gps = camera.children().find(|child| child.has_tag_name("reference"));
        let (Some(frame), Some(gps)) = (frame, gps) else { continue };
        let of = |name: &str| gps.attribute(name).unwrap().parse::<f64>().unwrap();
        let at = geocentric(of("x"), of("y"), of("z"));
        all.push(frame.pose.centre().distance(at));
        let down = frame.pose.to_world(DVec3::Z).dot(-at.normalize());
        assert!(!label.starts_with("nadir") || down > 0.85, "{label} looks {down} down");
    }
    // Heights of GPS are off by tens of metres, and as one.
    println!("{} cameras, median {} m", all.len(), median(all.clone()));
    assert!(all.len() > 50 && median(all) < 60.0);
}

#[test]
fn the_other_files_are_read_or_refused_by_name() {
    let Some(folder) = shared("formats") else { return };
    let read = |format, below: &str| read(format, &folder.join(below), &Sized(Size { width: 800, height: 800 }));
    let odm = read("opendronemap", "odm");
    let nadir = odm.frames[0].pose.to_world(DVec3::Z);
    assert!(
        nadir.z < -0.99 && odm.frames.iter().all(|frame| frame.pose.centre().truncate().length() < 1000.0),
        "{nadir}"
    );
    assert_eq!(read("transforms", "nerfstudio/fruit_transforms.json").frames.len(), 81);
    assert_eq!(read("transforms", "nerfstudio/dtu_transforms.json").frames.len(), 49);
    assert_eq!(
        read("transforms", "nerfstudio/lego_transforms_train.json").frames[0].camera.lens.focal().x.round(),
        1111.0
    );
    let facade = read("alicevision", "alicevision/meshroom_facade.sfm");
    assert_eq!((facade.frames.len(), facade.unposed.len()), (34, 17));
    assert!(!read("alicevision", "alicevision/meshroom2023.sfm").frames.is_empty());
    assert_eq!(read("openmvs", "openmvs").frames.len(), 4);
    assert!(read("pix4d", "pix4d/calibrated_camera_parameters.txt").frames.len() > 50);
    let format = FORMATS.iter().find(|one| one.name == "metashape").unwrap();
    let why = look(format, &folder.join("metashape/many_sensors.xml"), &NoPhotographs).unwrap_err().to_string();
    assert!(why.contains("b2 = ") && why.contains("no lens of gonio has it"), "{why}");
    for (below, name) in [
        ("odm", "opendronemap"),
        ("opensfm/berlin_reconstruction.json", "opensfm"),
        ("nerfstudio/lego_transforms_train.json", "transforms"),
        ("metashape/many_sensors.xml", "metashape"),
        ("tanks_and_temples/test.log", "tanks_and_temples"),
        ("nvm", "nvm"),
        ("bundler", "bundler"),
        ("alicevision/meshroom_facade.sfm", "alicevision"),
        ("openmvs", "openmvs"),
        ("micmac/Ori-Ground_mm3d", "micmac"),
        ("pix4d", "pix4d"),
    ] {
        let found: Vec<&str> = formats_at(&folder.join(below)).iter().map(|format| format.name).collect();
        assert_eq!(found, [name], "{below}");
    }
}
