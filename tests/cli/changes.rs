//! What changes between two runs: what is done again, what `explain` says of it, and that the result is a fresh run's.

use std::fs::{self, File};
use std::path::Path;
use std::time::SystemTime;

use gonio::internals::codec::poses::colmap::{self, Encoding};
use gonio::internals::codec::poses::{self, COLMAP};
use tempfile::TempDir;

use crate::files::{city, outputs};
use crate::ran::Ran;

/// The model of a few weights, which is quick.
fn tiny(dir: &TempDir) {
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/models");
    for name in ["conv4.onnx", "set4.onnx"] {
        fs::copy(model.join(name), dir.path().join(name)).unwrap();
    }
}

/// Exposures and light stay as they were first found; here they are left alone, so that a run that goes on gives what a fresh
/// one does.
const SETS: &str = "--set infer.model=conv4.onnx --set infer.backend=embedded --set gather.group=2 \
                    --set decode.exposure=as_is --set light.mode=unknown";

fn run(dir: &TempDir, work: &str, sets: &str) -> Ran {
    let ran = Ran::gonio(dir.path(), &format!("run p.toml {SETS} --set run.work={work} {sets}"));
    ran.ends(0);
    ran
}

fn explain(dir: &TempDir, sets: &str) -> Ran {
    let ran = Ran::gonio(dir.path(), &format!("explain p.toml {SETS} --set run.work=work {sets}"));
    ran.ends(0);
    ran
}

#[test]
fn a_touched_file_is_the_same_file() {
    let dir = city();
    tiny(&dir);
    explain(&dir, "").says("10 of 10").says("frame_003.jpg is new");
    run(&dir, "work", "");
    for file in ["mesh.ply", "images/frame_000.jpg", "sparse/0/images.bin", "conv4.onnx"] {
        let file = File::options().write(true).open(dir.path().join(file)).unwrap();
        file.set_modified(SystemTime::UNIX_EPOCH).unwrap();
    }
    explain(&dir, "").says("nothing is done over");
    let written = |name: &str| fs::metadata(dir.path().join("work").join(name)).unwrap().modified().unwrap();
    let names = ["materials.npy", "export/scene.glb", "units"];
    let before = names.map(written);
    run(&dir, "work", "").says("10 (0 cast, 10 from before").says("2 (0 inferred, 2 from before)");
    assert_eq!(names.map(written), before);
}

#[test]
fn one_image_takes_its_group_and_new_frames_take_none() {
    let dir = city();
    tiny(&dir);
    let images = dir.path().join("images");
    let model = dir.path().join("sparse/0");
    let all = poses::read(&COLMAP, &model, &poses::NoPhotographs).unwrap();
    // Frames 2 and 7 come later, in the midst of the others.
    let few: Vec<_> = all.iter().enumerate().filter(|(i, _)| ![2, 7].contains(i)).map(|(_, f)| f.clone()).collect();
    colmap::write_model(&model, &few, Encoding::Binary).unwrap();
    run(&dir, "work", "").says("8 (8 cast");
    fs::copy(images.join("frame_005.jpg"), images.join("frame_004.jpg")).unwrap();
    let said = explain(&dir, "");
    said.says("frames         2 of 8").says("the image of frame_004.jpg changed");
    assert!(!said.stdout().contains("frame_005"), "{said}");
    run(&dir, "work", "").says("8 (2 cast, 6 from before");
    colmap::write_model(&model, &all, Encoding::Binary).unwrap();
    let said = explain(&dir, "");
    said.says("frames         2 of 10").says("frame_002.jpg is new").says("frame_007.jpg is new");
    run(&dir, "work", "").says("10 (2 cast, 8 from before");
    run(&dir, "fresh", "");
    assert!(outputs(&dir.path().join("work")) == outputs(&dir.path().join("fresh")));
    // A frame that goes takes its group along: its observations cannot be told from the others' any more.
    colmap::write_model(&model, &all[1..], Encoding::Binary).unwrap();
    explain(&dir, "").says("frame_000.jpg is no longer among the poses").says("frames         1 of 9");
    run(&dir, "work", "").says("9 (1 cast, 8 from before");
    run(&dir, "less", "");
    assert!(outputs(&dir.path().join("work")) == outputs(&dir.path().join("less")));
}

#[test]
fn a_setting_takes_what_depends_on_it() {
    let dir = city();
    tiny(&dir);
    run(&dir, "work", "");
    for (sets, words, frames, shards) in [
        ("--set run.threads=1 --set cast.tile=64 --set gather.group=5", "nothing is done over", 0, 0),
        ("--set infer.model=set4.onnx", "infer.model changed", 0, 2),
        ("--set infer.model=conv4.onnx --set infer.min_bins=4", "infer.min_bins was 1 and is 4", 0, 2),
        ("--set merge.fill=false", "merge.fill was true and is false", 0, 2),
        ("--set scene.up=[0,1,0]", "scene.up was [0.0, 0.0, 1.0] and is [0.0, 1.0, 0.0]", 0, 0),
        (
            "--set scene.crs=UTM_33N --set scene.offset=[400000.5,5800000,0]",
            "scene.crs was none and is \"EPSG:32633\"",
            0,
            0,
        ),
        ("--set decode.transfer=linear", "decode.transfer was", 10, 2),
    ] {
        explain(&dir, sets).says(words);
        let ran = run(&dir, "work", sets);
        ran.says(&format!("10 ({frames} cast")).says(&format!("2 ({shards} inferred"));
        explain(&dir, sets).says("nothing is done over");
    }
}

#[test]
fn exports_and_report_say_where_the_scene_lies() {
    let dir = city();
    tiny(&dir);
    let place = "--set scene.crs=32633 --set scene.offset=[400000.5,5800000,0]";
    run(&dir, "work", place).says("coordinates    EPSG:32633 minus the offset 400000.5 5800000 0");
    let holds = |name: &str, words: &str| {
        let bytes = fs::read(dir.path().join("work").join(name)).unwrap();
        assert!(bytes.windows(words.len()).any(|part| part == words.as_bytes()), "{name} does not hold {words}");
    };
    holds("export/scene.ply", "comment crs EPSG:32633\ncomment offset 400000.5 5800000 0\n");
    holds("export/scene.glb", "\"crs\":\"EPSG:32633\",\"offset\":[400000.5,5800000.0,0.0]");
    holds("report.json", "\"crs\": \"EPSG:32633\"");
    let check = |sets: &str| Ran::gonio(dir.path(), &format!("check p.toml {SETS} --set run.work=work {sets}"));
    check(place).ends(0).says("up is [0.000, 0.000, 1.000], by the coordinate reference system");
    // The city is not where these say.
    check("--set scene.crs=32633").ends(0).says("the cameras stand about").says("one of the two is another");
    check("--set scene.crs=EPSG:2154").ends(0).says("coordinates are EPSG:2154");
}
