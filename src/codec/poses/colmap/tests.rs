use std::fs;
use std::path::Path;
use std::sync::Arc;

use glam::{DQuat, DVec2, DVec3};

use super::*;
use crate::base::Result;
use crate::codec::poses::{self, NoPhotographs};
use crate::scene::camera::{Camera, Distortion, Lens, Projection};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

fn read_model(folder: &Path) -> Result<Vec<Frame>> {
    poses::read(&COLMAP, folder, &NoPhotographs)
}

fn frames() -> Vec<Frame> {
    let lens = Lens::pinhole(DVec2::new(200.0, 210.0), DVec2::new(199.5, 150.25));
    let camera = |width| Arc::new(Camera::new(width, 300, lens.clone()).unwrap());
    let cameras = [camera(400), camera(500)];
    let frame = |i: u32, name: &str| Frame {
        name: name.to_owned(),
        camera: Arc::clone(&cameras[i as usize % 2]),
        pose: Pose {
            rotation: DQuat::from_rotation_x(0.1 + f64::from(i)),
            translation: DVec3::new(1.0, -2.5, 1e6 + 1.0 / 3.0),
        },
    };
    ["a b.jpg", "flight 2/c.jpg", "z.jpg"].into_iter().enumerate().map(|(i, n)| frame(i as u32, n)).collect()
}

fn written(encoding: Encoding) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    write_model(folder.path(), &frames(), encoding).unwrap();
    folder
}

fn close(a: &[Frame], b: &[Frame]) -> bool {
    let near = |a: &Frame, b: &Frame| {
        let turned = a.pose.rotation.dot(b.pose.rotation).abs();
        (&a.name, &a.camera) == (&b.name, &b.camera) && a.pose.translation == b.pose.translation && turned > 1.0 - 1e-12
    };
    a.len() == b.len() && a.iter().zip(b).all(|(a, b)| near(a, b))
}

#[test]
fn both_encodings_are_read_as_they_were_written() {
    for encoding in [Encoding::Binary, Encoding::Text] {
        assert!(close(&read_model(written(encoding).path()).unwrap(), &frames()), "{encoding:?}");
    }
}

#[test]
fn the_binary_model_counts_where_both_are_there() {
    let folder = written(Encoding::Binary);
    fs::write(folder.path().join("cameras.txt"), "nonsense").unwrap();
    fs::write(folder.path().join("images.txt"), "nonsense").unwrap();
    fs::write(folder.path().join("rigs.bin"), "nonsense").unwrap();
    assert_eq!(read_model(folder.path()).unwrap().len(), 3);
    fs::remove_file(folder.path().join("images.bin")).unwrap();
    assert!(read_model(folder.path()).is_err());
}

#[test]
fn every_cut_of_a_binary_model_is_refused() {
    for name in ["cameras.bin", "images.bin"] {
        let folder = written(Encoding::Binary);
        let path = folder.path().join(name);
        let bytes = fs::read(&path).unwrap();
        for length in 0..bytes.len() {
            fs::write(&path, &bytes[..length]).unwrap();
            assert!(read_model(folder.path()).is_err(), "{name} cut to {length}");
        }
        fs::write(&path, [&bytes[..], &[0]].concat()).unwrap();
        assert!(read_model(folder.path()).is_err(), "{name} with a byte more");
    }
}

#[test]
fn no_flipped_byte_panics() {
    let files = [("cameras", "bin", Encoding::Binary), ("images", "bin", Encoding::Binary)];
    for (stem, ending, encoding) in files.into_iter().chain(files.map(|f| (f.0, "txt", Encoding::Text))) {
        let folder = written(encoding);
        let path = folder.path().join(stem).with_extension(ending);
        let bytes = fs::read(&path).unwrap();
        for at in 0..bytes.len() {
            let mut flipped = bytes.clone();
            flipped[at] ^= 0xff;
            fs::write(&path, flipped).unwrap();
            let _ = read_model(folder.path());
        }
    }
}

#[test]
fn faults_name_file_element_and_what_was_found() {
    let cameras = "1 PINHOLE 400 300 200 200 200 150\n";
    let image = "7 1 0 0 0 1 2 3 1 a.jpg\n\n";
    for (cameras, images, words) in [
        ("1 PINHOLE 400 300 200 200 200\n", image, "line 1"),
        ("1 FISHEYE_EYE 400 300 200 200 200 150\n", image, "FISHEYE_EYE"),
        ("1 PINHOLE 0 300 200 200 200 150\n", image, "line 1"),
        ("1 PINHOLE 400 300 nan 200 200 150\n", image, "line 1"),
        ("1 PINHOLE 400 300 2 2 2 1\n1 PINHOLE 400 300 2 2 2 1\n", image, "another camera"),
        (cameras, "7 1 0 0 0 1 2 3 2 a.jpg\n\n", "camera 2"),
        (cameras, "7 0 0 0 0 1 2 3 1 a.jpg\n\n", "quaternion"),
        (cameras, "7 1 0 0 0 1 inf 3 1 a.jpg\n\n", "translation"),
        (cameras, "7 1 0 0 0 1 2 3 1 ../a.jpg\n\n", "../a.jpg"),
        (cameras, "7 1 0 0 0 1 2 3 1 /etc/a.jpg\n\n", "/etc/a.jpg"),
        (cameras, "7 1 0 0 0 1 2 3 1\n\n", "name"),
        (cameras, "7 1 0 0 0 1 2 x 1 a.jpg\n\n", "\"x\""),
        (cameras, "7 1 0 0 0 1 2 3 1 a.jpg\n\n8 1 0 0 0 1 2 3 1 a.jpg\n\n", "two images"),
    ] {
        let folder = tempfile::tempdir().unwrap();
        fs::write(folder.path().join("cameras.txt"), cameras).unwrap();
        fs::write(folder.path().join("images.txt"), images).unwrap();
        let error = read_model(folder.path()).unwrap_err().to_string();
        assert!(error.contains(words), "{cameras}{images}: {error}");
    }
}

#[test]
fn a_panorama_is_refused_only_where_an_image_uses_it() {
    let cameras = "1 PINHOLE 400 300 200 200 200 150\n2 EQUIRECTANGULAR 800 400 800 400\n";
    let image = "7 1 0 0 0 1 2 3 1 a.jpg\n\n";
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cameras.txt"), cameras).unwrap();
    fs::write(folder.path().join("images.txt"), image).unwrap();
    assert_eq!(read_model(folder.path()).unwrap().len(), 1);
    fs::write(folder.path().join("images.txt"), format!("{image}8 1 0 0 0 1 2 3 2 b.jpg\n\n")).unwrap();
    let why = read_model(folder.path()).unwrap_err().to_string();
    assert!(why.contains("line 3: its camera is of the model EQUIRECTANGULAR, which has no lens"), "{why}");
}

#[test]
fn comments_points_and_line_ends_of_either_kind_are_passed_over() {
    let folder = tempfile::tempdir().unwrap();
    fs::write(folder.path().join("cameras.txt"), "# c\r\n\r\n3 SIMPLE_PINHOLE 400 300 200 200 150\r\n").unwrap();
    fs::write(
        folder.path().join("images.txt"),
        "# i\n9 1 0 0 0 1 2 3 3 b.jpg\n1.5 2.5 -1 3 4 7\n\n2 1 0 0 0 1 2 3 3 my a.jpg\n\n5 1 0 0 0 1 2 3 3 c.jpg",
    )
    .unwrap();
    let names: Vec<String> = read_model(folder.path()).unwrap().into_iter().map(|f| f.name).collect();
    assert_eq!(names, ["b.jpg", "c.jpg", "my a.jpg"]);
}

#[test]
fn a_real_model_reads_the_same_in_both_encodings() {
    let data = Path::new(env!("CARGO_MANIFEST_DIR")).join("../shared/data/boruszyn");
    if !data.is_dir() {
        println!("skipped: {} is not there", data.display());
        return;
    }
    let (binary, text) =
        (read_model(&data.join("sparse/0")).unwrap(), read_model(&data.join("sparse_text/0")).unwrap());
    assert_eq!(binary.len(), 28);
    for (a, b) in binary.iter().zip(&text) {
        assert_eq!(a.name, b.name);
        assert!(a.pose.centre().distance(b.pose.centre()) < 1e-6);
        assert_eq!((a.camera.width, a.camera.height), (b.camera.width, b.camera.height));
    }
}

#[test]
fn a_folder_without_a_model_says_where_one_is() {
    let folder = tempfile::tempdir().unwrap();
    let missing = (COLMAP.missing)(folder.path()).unwrap();
    assert_eq!((missing.rule, missing.instead), ("must hold cameras.bin and images.bin, or both as .txt", None));
    let below = folder.path().join("sparse/0");
    fs::create_dir_all(&below).unwrap();
    fs::write(below.join("cameras.txt"), "").unwrap();
    assert_eq!((COLMAP.missing)(folder.path()).unwrap().instead, None);
    fs::write(below.join("images.txt"), "").unwrap();
    assert_eq!((COLMAP.missing)(folder.path()).unwrap().instead, Some(below.clone()));
    assert_eq!((COLMAP.missing)(&below), None);
    // That nothing is there is another fault.
    assert_eq!((COLMAP.missing)(&folder.path().join("nowhere")), None);
}

#[test]
fn a_lens_that_no_model_has_is_not_written() {
    let lens = |projection| Lens::new(DVec2::splat(100.0), DVec2::splat(50.0), projection).unwrap();
    let folder = tempfile::tempdir().unwrap();
    for (projection, words) in [
        (
            Projection::Perspective(Distortion::radial([0.1, 0.0, 0.0, 0.2])),
            "no camera model of COLMAP has the terms k1, k4 of a perspective lens",
        ),
        (
            Projection::Equidistant(Distortion { rational: [0.0, 0.1, 0.0], chained: true, ..Distortion::default() }),
            "no camera model of COLMAP has the terms d2, chained of an equidistant lens",
        ),
    ] {
        let mut frames = frames();
        frames[1].camera = Arc::new(Camera { width: 100, height: 100, lens: lens(projection) });
        let why = write_model(folder.path(), &frames, Encoding::Text).unwrap_err().to_string();
        assert!(why.contains("cannot write the camera of flight 2/c.jpg") && why.contains(words), "{why}");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }
}
