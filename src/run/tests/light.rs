//! Exposures and light: found once and then kept, whatever frames come, change or cannot be tied, and redone for what changed.

use std::ffi::OsString;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use tempfile::TempDir;

use super::{outputs, run_here};
use crate::codec::images::{Curve, Size, Transfer, read_image, size, to_srgb8, write_jpeg};
use crate::codec::poses::colmap::{self, Encoding};
use crate::codec::poses::{self, COLMAP, NoPhotographs};
use crate::disk::{MemStore, Store};
use crate::phases::Report;
use crate::phases::light::LIGHT;
use crate::pipeline::load;
use crate::scene::evidence::{Evidence, Filled};
use crate::stages::merge::Materials;
use crate::synth::city::{self, CityConfig};

/// The sun of the city.
const SUN: [f64; 3] = [-0.456_345_98, -0.506_823_54, 0.731_353_70];

/// A city that a light can be found in, and a pipeline file that says nothing of it.
fn scene() -> TempDir {
    scene_of(CityConfig::default())
}

/// One of such a city.
pub(super) fn scene_of(city: CityConfig) -> TempDir {
    let dir = TempDir::new().unwrap();
    let config = CityConfig { triangles: 5000, frames: 8, width: 320, height: 240, supersampling: 1, ..city };
    city::write::generate(dir.path(), &config, &|| false).unwrap();
    let text = "[scene]\nmesh = \"mesh.ply\"\nimages = \"images\"\nposes = { format = \"colmap\", path = \"sparse/0\" }\n\
                [gather]\ngroup = 2\n[infer]\nbackend = \"embedded\"\nmodel = \"MODEL\"\n[run]\nwork = \"work\"\nthreads = 2\n";
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/models/conv4.onnx");
    fs::write(dir.path().join("p.toml"), text.replace("MODEL", &model.display().to_string())).unwrap();
    dir
}

/// Runs it, with these settings, and gives what it reports, what it notes and what it says of the light.
pub(super) fn run(dir: &TempDir, store: &MemStore, sets: &[&str]) -> (Report, Vec<String>, Option<serde_json::Value>) {
    let sets: Vec<OsString> = sets.iter().map(OsString::from).collect();
    let pipeline = load(&dir.path().join("p.toml"), &sets).unwrap();
    let (report, notes) = run_here(Arc::new(store.clone()), &pipeline).unwrap();
    let told = store.open(LIGHT).ok().map(|bytes| serde_json::from_slice(&bytes).unwrap());
    (report, notes, told)
}

/// Degrees between a sun and the city's.
fn off(sun: Option<[f64; 3]>) -> f64 {
    let sun = glam::DVec3::from(sun.expect("a sun was found"));
    sun.angle_between(SUN.into()).to_degrees()
}

/// Makes a photograph darker by this factor, in linear light.
fn darken(image: &Path, by: f32) {
    let curve = Curve::new(Transfer::Srgb);
    let Size { width, height } = size(image).unwrap();
    let found = read_image(image, Size { width, height }, &curve, 1 << 30).unwrap();
    let pixel = |at| found.pixel(at).unwrap().rgb.map(|v| to_srgb8(v * by));
    write_jpeg(image, &(0..found.len()).map(pixel).collect::<Vec<_>>(), width, height, 98).unwrap();
}

/// Half of the frames are taken in the morning, half after noon.
#[test]
fn frames_of_two_suns_have_each_its_own() {
    let suns = vec![[38.0, 115.0], [50.0, 240.0]];
    let dir = scene_of(CityConfig { suns: suns.clone(), ..CityConfig::default() });
    let (first, store) = (MemStore::new(), MemStore::new());
    let (report, notes, told) = run(&dir, &store, &[]);
    let told = told.unwrap();
    let towards = |[elevation, azimuth]: [f64; 2]| {
        let (up, around) = (elevation.to_radians(), azimuth.to_radians());
        glam::DVec3::new(up.cos() * around.cos(), up.cos() * around.sin(), up.sin())
    };
    let other = &told["others"][0];
    let found = [&told["sun"], &other["sun"]].map(|sun| {
        let sun: [f64; 3] = serde_json::from_value(sun.clone()).unwrap();
        glam::DVec3::from(sun)
    });
    // Which of the two comes first depends on how surely each was found.
    let off = |order: [usize; 2]| {
        (0..2).map(|i| found[i].angle_between(towards(suns[order[i]])).to_degrees()).fold(0.0, f64::max)
    };
    let swapped = off([1, 0]) < off([0, 1]);
    assert!(off([0, 1]).min(off([1, 0])) < 4.0, "{found:?} {notes:?}");
    let frames: Vec<String> = serde_json::from_value(other["frames"].clone()).unwrap();
    let half = if swapped { "frame_000.jpg" } else { "frame_004.jpg" };
    assert_eq!((frames.len(), frames[0].as_str()), (4, half));
    // One scale for both: the city's suns are as bright as each other.
    for c in 0..3 {
        let ratio = other["color"][c].as_f64().unwrap() / told["color"][c].as_f64().unwrap();
        assert!((0.85..1.18).contains(&ratio), "channel {c}: {ratio}");
    }
    assert!(report.light.unwrap().words.contains("4 photographs were taken in another light"));
    // The same again, and nothing is done over.
    let (again, ..) = run(&dir, &store, &[]);
    assert_eq!((again.frames.cast, again.shards.inferred), (0, 0));
    run(&dir, &first, &["run.threads=1"]);
    assert_eq!(outputs(&first), outputs(&store));
}

#[test]
fn a_city_of_which_nothing_is_known_gives_its_sun_away() {
    let (dir, store) = (scene(), MemStore::new());
    let (report, notes, told) = run(&dir, &store, &[]);
    let light = report.light.unwrap();
    assert!(off(light.sun) < 4.0, "{light:?}");
    assert!(report.backend.contains("fit"), "{}", report.backend);
    assert_eq!((light.gains, &light.untied), (8, &vec![]), "{notes:?}");
    assert!(light.gain_range[0] > 0.9 && light.gain_range[1] < 1.1, "{light:?}");
    let told = told.unwrap();
    assert_eq!(told["sun"], serde_json::json!(light.sun));
    // The same again, on one thread, byte by byte.
    let other = MemStore::new();
    run(&dir, &other, &["run.threads=1", "cast.tile=8"]);
    assert!(outputs(&store) == outputs(&other));
    assert!(["light.json", "light.png"].iter().all(|name| *store.open(name).unwrap() == *other.open(name).unwrap()));
}

#[test]
fn what_was_found_stays_when_frames_come_and_change() {
    let (dir, store) = (scene(), MemStore::new());
    let model = dir.path().join("sparse/0");
    let all = poses::read(&COLMAP, &model, &NoPhotographs).unwrap();
    let few: Vec<_> = all.iter().enumerate().filter(|(i, _)| *i != 3).map(|(_, frame)| frame.clone()).collect();
    colmap::write_model(&model, &few, Encoding::Binary).unwrap();
    let (first, _, before) = run(&dir, &store, &[]);
    assert_eq!(first.frames.cast, 7);
    let before = before.unwrap();
    // A frame that comes is tied to the others, and nothing else is done over.
    colmap::write_model(&model, &all, Encoding::Binary).unwrap();
    darken(&dir.path().join("images/frame_003.jpg"), 0.5);
    let (second, _, after) = run(&dir, &store, &[]);
    let after = after.unwrap();
    assert_eq!((second.frames.cast, second.frames.resumed), (1, 7));
    let gains = |told: &serde_json::Value| told["gains"]["frames"].as_object().unwrap().clone();
    let (old, new) = (gains(&before), gains(&after));
    assert!(old.iter().all(|(name, gain)| new[name] == *gain) && new.len() == old.len() + 1, "{old:?} {new:?}");
    let gain = new["frame_003.jpg"].as_f64().unwrap();
    assert!((0.45..0.55).contains(&gain), "{gain}");
    assert_eq!((&before["sun"], &before["sky"]), (&after["sun"], &after["sky"]));
    // A photograph that changes takes its group along, with a gain of its own.
    darken(&dir.path().join("images/frame_006.jpg"), 0.7);
    let (third, _, last) = run(&dir, &store, &[]);
    assert_eq!((third.frames.cast, third.frames.resumed), (2, 6));
    let newest = gains(&last.unwrap());
    let (was, is) = (new["frame_006.jpg"].as_f64().unwrap(), newest["frame_006.jpg"].as_f64().unwrap());
    assert!((is / was - 0.7).abs() < 0.05, "{was} {is}");
    assert!(new.iter().filter(|(name, _)| *name != "frame_006.jpg").all(|(name, gain)| newest[name] == *gain));
    assert_eq!(run(&dir, &store, &[]).0.frames.cast, 0);
}

#[test]
fn frames_that_are_exposed_otherwise_cast_the_same() {
    let (dir, store, other) = (scene(), MemStore::new(), MemStore::new());
    let unlit = ["light.mode=unknown"];
    run(&dir, &store, &unlit);
    darken(&dir.path().join("images/frame_002.jpg"), 0.6);
    darken(&dir.path().join("images/frame_005.jpg"), 0.8);
    let (solved, _, told) = run(&dir, &other, &unlit);
    assert_eq!(solved.light.unwrap().sun, None);
    assert!(told.unwrap()["sun"].is_null());
    let (as_is, _, told) = run(&dir, &MemStore::new(), &["light.mode=unknown", "decode.exposure=as_is"]);
    assert_eq!((as_is.light, told), (None, None), "nothing is looked for");
    let radiance = |store: &MemStore| {
        let evidence = Materials::open(store).unwrap().evidence;
        evidence.iter().map(|row| f64::from(row[6])).filter(|v| v.is_finite()).collect::<Vec<_>>()
    };
    let (wanted, found) = (radiance(&store), radiance(&other));
    let off: f64 = wanted.iter().zip(&found).map(|(a, b)| (a - b).abs()).sum::<f64>() / wanted.iter().sum::<f64>();
    assert!(off < 0.03, "{off}");
}

#[test]
fn where_no_sun_is_found_the_sky_is_the_light() {
    let (dir, store) = (scene(), MemStore::new());
    // A scene of one colour gives nothing away.
    for image in fs::read_dir(dir.path().join("images")).unwrap() {
        write_jpeg(&image.unwrap().path(), &vec![[120; 3]; 320 * 240], 320, 240, 95).unwrap();
    }
    let (report, _, _) = run(&dir, &store, &["decode.exposure=as_is"]);
    let light = report.light.unwrap();
    assert!(light.sun.is_none() && light.words.contains("triangles"), "{light:?}");
    assert!(light.words.contains("overcast") && report.backend.contains("fit"), "{light:?} {}", report.backend);
    let Materials { rows, evidence } = Materials::open(&store).unwrap();
    let evidence: Vec<Evidence> = evidence.iter().map(|row| Evidence::from_array(*row)).collect();
    assert!(evidence.iter().all(|evidence| evidence.lit.is_nan()));
    // Where less of the sky is seen, the same radiance comes of a brighter surface.
    let kd = rows.iter().zip(&evidence).filter(|(_, e)| e.filled == Filled::Observed).map(|(row, _)| row[0]);
    let (low, high) = kd.fold((1f32, 0f32), |(low, high), kd| (low.min(kd), high.max(kd)));
    assert!(high > 1.3 * low, "{low} {high}");
}

#[test]
fn where_too_little_is_seen_the_network_answers_and_it_is_said() {
    let (dir, store, other) = (scene(), MemStore::new(), MemStore::new());
    for image in fs::read_dir(dir.path().join("images")).unwrap().skip(1) {
        fs::remove_file(image.unwrap().path()).unwrap();
    }
    let (report, _, _) = run(&dir, &store, &[]);
    let light = report.light.unwrap();
    assert!(light.sun.is_none() && light.words.contains("too few"), "{light:?}");
    run(&dir, &other, &["light.mode=unknown"]);
    assert!(outputs(&store) == outputs(&other));
    let pipeline = load(&dir.path().join("p.toml"), &["infer.estimator=fit".into()]).unwrap();
    let why = run_here(Arc::new(MemStore::new()), &pipeline).unwrap_err().to_string();
    assert!(why.contains("no light was found") && why.contains("estimator = \"auto\""), "{why}");
}
