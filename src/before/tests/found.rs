//! What is told, and the file that is written.

use std::fs;

use super::folder::Folder;
use crate::before::{Found, not_there, text, write};
use crate::pipeline::load;

const NAMES: [&str; 2] = ["a.png", "b.png"];

/// A project that has all that a run needs.
fn whole() -> Folder {
    let size = [40, 30];
    let folder = Folder::new().model("sparse/0", size, &NAMES).mesh("dense/meshed-poisson.ply", 2);
    folder.picture("images/a.png", size).picture("images/b.png", size)
}

fn found(folder: &Folder) -> Found {
    Found::at(folder.path()).unwrap()
}

fn told(folder: &Folder) -> String {
    found(folder).lines().join("\n")
}

#[test]
fn a_whole_project_is_told_and_its_file_is_good() {
    let folder = whole().cloud("dense/fused.ply").picture("masks/a.png.png", [40, 30]);
    let found = found(&folder);
    assert_eq!(found.missing(), [""; 0]);
    insta::assert_snapshot!(found.lines().join("\n"), @r"
    poses        sparse/0: colmap (COLMAP, GLOMAP), 2 frames of 40 x 30 pixels
    lens         one without distortion, of a focal length of 50.0 pixels
    axes         up is [0.000, -1.000, 0.000], by cameras that are level but for 0.0 degrees
    photographs  images: 2 of 2
    flight       no photograph tells when or where it was taken
    exposure     no photograph tells how it was exposed
    masks        masks: 1 of 2 photographs have one
    mesh         dense/meshed-poisson.ply, 188 B, 100% of it before the cameras
    ");
    let file = not_there(folder.path()).unwrap();
    write(&file, &text(&found)).unwrap();
    let pipeline = load(folder.path(), &[]).unwrap();
    let at = |name: &str| folder.path().join(name);
    assert_eq!((pipeline.scene.mesh, pipeline.scene.images), (at("dense/meshed-poisson.ply").into(), at("images")));
    assert_eq!((pipeline.scene.poses.path, pipeline.scene.masks), (at("sparse/0"), Some(at("masks"))));
    assert_eq!((pipeline.run.work, pipeline.decode.downscale, pipeline.file), (at("gonio"), 1, file));
}

#[test]
fn every_key_is_explained_and_what_is_not_found_has_its_default() {
    let text = text(&found(&whole()));
    let template = crate::pipeline::template();
    let keys = |text: &str| text.lines().filter(|line| !line.starts_with("# ") || line.contains(" = ")).count();
    assert!(keys(&text) >= keys(&template) - 3, "{text}");
    assert!(text.contains("\n# masks = ") && text.contains("\ndownscale = 1\n"), "{text}");
}

#[test]
fn a_file_that_is_there_is_never_overwritten() {
    let folder = whole().with("gonio.toml", "mine");
    assert!(not_there(folder.path()).unwrap_err().to_string().contains("never overwritten"));
    let file = folder.path().join("gonio.toml");
    assert!(write(&file, "other").is_err(), "not even when it came in between");
    assert_eq!(fs::read_to_string(file).unwrap(), "mine");
}

#[test]
fn sizes_that_do_not_fit_are_told_and_a_downscale_is_set() {
    // Programs round a side down or up.
    for size in [[40, 30], [41, 31]] {
        let half = Folder::new().model("sparse/0", [81, 61], &NAMES).mesh("mesh.ply", 1);
        let half = half.picture("images/a.png", size).picture("images/b.png", size);
        assert!(told(&half).contains("images: 2 of 2; 2 times smaller than the cameras"), "{}", told(&half));
        assert!(text(&found(&half)).contains("\ndownscale = 2\n"));
    }
    let large = Folder::new().model("sparse/0", [40, 30], &NAMES).mesh("mesh.ply", 1);
    let large = large.picture("images/a.png", [80, 60]).picture("images/b.png", [80, 60]);
    assert!(told(&large).contains("a.png has 80 x 60 pixels, and its camera 40 x 30; these may be the originals"));
    assert_eq!(found(&large).missing().len(), 1);
}

#[test]
fn what_is_missing_is_told_with_the_command_that_makes_it() {
    let missing = |folder: Folder| Found::at(folder.path()).unwrap().missing().join("\n");
    let size = [40, 30];
    let bare = || Folder::new().picture("images/a.png", size).picture("images/b.png", size);
    insta::assert_snapshot!(missing(bare().model("sparse/0", size, &NAMES)), @r"
    missing: the mesh, in the coordinates of the poses
      colmap image_undistorter --image_path images --input_path sparse/0 --output_path dense
      colmap patch_match_stereo --workspace_path dense
      colmap stereo_fusion --workspace_path dense --output_path dense/fused.ply
      colmap poisson_mesher --input_path dense/fused.ply --output_path dense/meshed-poisson.ply
    ");
    let clouded = missing(bare().model("sparse/0", size, &NAMES).cloud("dense/0/fused.ply"));
    assert!(clouded.contains("dense/0/fused.ply is none: ") && clouded.contains("no element face"), "{clouded}");
    let command = "colmap poisson_mesher --input_path dense/0/fused.ply --output_path dense/meshed-poisson.ply";
    assert!(clouded.ends_with(command), "{clouded}");
    insta::assert_snapshot!(missing(bare().with("database.db", "").mesh("mesh.ply", 1)), @r"
    missing: where the cameras stood
      colmap mapper --database_path database.db --image_path images --output_path sparse
    ");
    insta::assert_snapshot!(missing(Folder::new().model("sparse/0", size, &NAMES).mesh("mesh.ply", 1)), @r"
    missing: the photographs
      none of those that the poses name is here, as a.png; put them into images, or link it
    ");
}

#[test]
fn a_folder_of_nothing_is_refused() {
    let why = Found::at(Folder::new().with("notes.txt", "").path()).unwrap_err().to_string();
    assert!(why.contains("neither poses nor photographs nor a mesh") && why.contains("colmap (COLMAP"), "{why}");
    let folder = Folder::new().with("a.ply", "");
    assert!(Found::at(&folder.path().join("a.ply")).unwrap_err().to_string().contains("is a file"));
    assert!(Found::at(&folder.path().join("none")).unwrap_err().to_string().contains("cannot list"));
}

#[test]
fn the_flight_and_its_exposures_are_told() {
    use exif::{Rational, Tag, Value};

    use crate::codec::images::exif_made::{field, said, tell};
    let folder = Folder::new().model("sparse/0", [40, 30], &["a.jpg", "b.jpg"]).mesh("mesh.ply", 1);
    let folder = folder.picture("images/a.jpg", [40, 30]).picture("images/b.jpg", [40, 30]);
    let taken = |name: &str, time: &str, iso: u16| {
        let seconds = Value::Rational(vec![Rational { num: 1, denom: 500 }]);
        let iso = field(Tag::PhotographicSensitivity, Value::Short(vec![iso]));
        let clock = said(Tag::DateTimeOriginal, time);
        tell(&folder.path().join("images").join(name), &[clock, field(Tag::ExposureTime, seconds), iso]);
    };
    taken("a.jpg", "2014:05:26 12:40:00", 100);
    let one = told(&folder);
    assert!(one.contains("exposure     1 of 2 photographs tell how they were exposed"), "{one}");
    taken("b.jpg", "2014:05:26 12:50:00", 100);
    let locked = told(&folder);
    assert!(
        locked.contains("flight       2014-05-26T12:50:00, by a clock of unknown zone, 10 minutes long"),
        "{locked}"
    );
    assert!(locked.contains("exposure     locked: 1/500 s, ISO 100, in all of 2"), "{locked}");
    taken("b.jpg", "2014:05:26 12:50:00", 400);
    assert!(told(&folder).contains("exposure     not locked: 2 settings in 2"), "{}", told(&folder));
}
