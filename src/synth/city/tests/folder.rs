use std::cell::RefCell;
use std::collections::BTreeMap;
use std::fs;
use std::path::Path;

use super::build;
use super::small;
use crate::codec::meshes;
use crate::codec::tables::npy;
use crate::synth::city::{CityConfig, folder, generate_if_needed};

pub(super) const GO_ON: &dyn Fn() -> bool = &|| false;

/// Every file below a folder by its path, with its bytes.
pub(super) fn files(folder: &Path) -> BTreeMap<String, Vec<u8>> {
    let mut found = BTreeMap::new();
    for entry in fs::read_dir(folder).unwrap().map(Result::unwrap) {
        let name = entry.file_name().into_string().unwrap();
        if entry.file_type().unwrap().is_dir() {
            found.extend(files(&entry.path()).into_iter().map(|(below, bytes)| (format!("{name}/{below}"), bytes)));
        } else {
            found.insert(name, fs::read(entry.path()).unwrap());
        }
    }
    found
}

#[test]
fn the_files_hold_the_city() {
    let dir = tempfile::tempdir().unwrap();
    let (at, config) = (dir.path().join("new/city"), small(4));
    let taken = RefCell::default();
    let summary = generate_if_needed(&at, &config, GO_ON, &|now| Vec::push(&mut taken.borrow_mut(), now)).unwrap();
    assert_eq!(taken.into_inner(), [0, 1, 2, 3]);
    let names: Vec<String> = files(&at).into_keys().collect();
    let expected = [
        "city.json",
        "images/frame_000.jpg",
        "images/frame_001.jpg",
        "images/frame_002.jpg",
        "mesh.ply",
        "sparse/0/cameras.bin",
        "sparse/0/images.bin",
        "sparse/0/points3D.bin",
        "truth/light.json",
        "truth/materials.npy",
    ];
    assert_eq!(names, expected);
    let city = build(&config).unwrap();
    assert_eq!((summary.triangles, summary.frames, summary.reused), (city.mesh.len() as u64, 3, false));
    let mesh = meshes::read(&at.join("mesh.ply"), &|_| Ok(())).unwrap();
    assert_eq!(mesh.triangles, city.mesh.triangles);
    let places = |m: &crate::scene::Mesh| m.positions.iter().map(|p| m.origin + p.as_dvec3()).collect::<Vec<_>>();
    for (a, b) in places(&mesh).into_iter().zip(places(&city.mesh)) {
        assert!(a.distance(b) < 1e-4, "{a} {b}");
    }
    let truth = npy::read_rows::<7>(&at.join("truth/materials.npy")).unwrap();
    assert!(truth.iter().copied().eq(city.materials.iter().map(|m| m.to_array())));
}

#[test]
fn threads_do_not_change_a_byte() {
    let made = |threads: usize| {
        let dir = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| generate_if_needed(dir.path(), &small(5), GO_ON, &|_| {})).unwrap();
        files(dir.path())
    };
    assert_eq!(made(1), made(3));
}

#[test]
fn a_finished_city_is_reused_and_an_interrupted_one_made_again() {
    let (dir, config) = (tempfile::tempdir().unwrap(), small(6));
    assert!(!generate_if_needed(dir.path(), &config, GO_ON, &|_| {}).unwrap().reused);
    let whole = files(dir.path());
    assert!(generate_if_needed(dir.path(), &config, GO_ON, &|_| {}).unwrap().reused);
    assert_eq!(files(dir.path()), whole);
    // Killed while it was being made again: a torn picture, one not yet there, a temporary file.
    folder::begin(dir.path()).unwrap();
    fs::write(dir.path().join("images/frame_001.jpg"), b"torn").unwrap();
    fs::remove_file(dir.path().join("images/frame_002.jpg")).unwrap();
    fs::write(dir.path().join("images/frame_002.jpg.7-0.gonio-tmp"), b"left").unwrap();
    assert!(!generate_if_needed(dir.path(), &config, GO_ON, &|_| {}).unwrap().reused);
    assert_eq!(files(dir.path()), whole);
}

#[test]
fn what_a_city_did_not_make_stays() {
    let (dir, notes) = (tempfile::tempdir().unwrap(), tempfile::tempdir().unwrap());
    generate_if_needed(dir.path(), &small(6), GO_ON, &|_| {}).unwrap();
    let own = ["images/frame_notes.txt", "images/frame_001.jpg.bak", "images/frame_1_mask.png", "images/x.gonio-tmp"];
    folder::begin(dir.path()).unwrap();
    fs::create_dir(dir.path().join("unfinished")).unwrap();
    let own = own.into_iter().chain(["unfinished/thesis.tex", "notes.md"]);
    own.clone().for_each(|name| fs::write(dir.path().join(name), "precious").unwrap());
    generate_if_needed(dir.path(), &small(5), GO_ON, &|_| {}).unwrap();
    assert!(own.into_iter().all(|name| fs::read(dir.path().join(name)).unwrap() == b"precious"));
    // A link in a folder's place would lead to somebody's photographs.
    #[cfg(unix)]
    {
        fs::write(notes.path().join("frame_007.jpg"), "precious").unwrap();
        fs::remove_dir_all(dir.path().join("images")).unwrap();
        std::os::unix::fs::symlink(notes.path(), dir.path().join("images")).unwrap();
        folder::begin(dir.path()).unwrap();
        let why = generate_if_needed(dir.path(), &small(6), GO_ON, &|_| {}).unwrap_err().to_string();
        assert!(why.contains("images: it is a link or a file, where a folder of the city's is needed"), "{why}");
        assert_eq!(fs::read(notes.path().join("frame_007.jpg")).unwrap(), b"precious");
    }
}

#[test]
fn an_interrupted_city_keeps_its_photographs() {
    let whole = tempfile::tempdir().unwrap();
    generate_if_needed(whole.path(), &small(6), GO_ON, &|_| {}).unwrap();
    let dir = tempfile::tempdir().unwrap();
    // Photographs of another city are there under the same names.
    generate_if_needed(dir.path(), &small(5), GO_ON, &|_| {}).unwrap();
    let images = dir.path().join("images");
    let after_one = || folder::owned(dir.path(), &small(6)) && images.join("frame_000.jpg").exists();
    assert!(generate_if_needed(dir.path(), &small(6), &after_one, &|_| {}).unwrap_err().is_interrupt());
    assert_eq!(fs::read_dir(&images).unwrap().count(), 1);
    let first = fs::metadata(images.join("frame_000.jpg")).unwrap().modified().unwrap();
    fs::write(images.join("frame_001.jpg.7-0.gonio-tmp"), b"left").unwrap();
    generate_if_needed(dir.path(), &small(6), GO_ON, &|_| {}).unwrap();
    assert_eq!(fs::metadata(images.join("frame_000.jpg")).unwrap().modified().unwrap(), first);
    assert_eq!(files(dir.path()), files(whole.path()));
}

#[test]
fn whenever_it_is_interrupted_it_goes_on_and_nothing_is_made_twice() {
    let whole = tempfile::tempdir().unwrap();
    generate_if_needed(whole.path(), &small(6), GO_ON, &|_| {}).unwrap();
    let dir = tempfile::tempdir().unwrap();
    let made = |name: &str| fs::metadata(dir.path().join(name)).and_then(|m| m.modified()).ok();
    // Each making is stopped one question later than the one before, until one gets to its end.
    let mut makings = 0;
    loop {
        let before = ["mesh.ply", "unfinished/scene.cache", "unfinished/sky"].map(made);
        let asked = std::cell::Cell::new(0);
        let stop = || asked.replace(asked.get() + 1) >= makings;
        let done = generate_if_needed(dir.path(), &small(6), &stop, &|_| {});
        makings += 1;
        if done.is_ok() {
            break;
        }
        assert!(done.unwrap_err().is_interrupt());
        let after = ["mesh.ply", "unfinished/scene.cache", "unfinished/sky"].map(made);
        // Without a cache the mesh is made once more; with one, nothing is that was there.
        if before[1].is_some() {
            assert!(before.iter().zip(&after).all(|(b, a)| b.is_none() || b == a), "making {makings}");
        }
    }
    assert!(makings > 3, "{makings}");
    assert_eq!(files(dir.path()), files(whole.path()));
}

#[test]
fn what_it_is_rendered_with_is_made_again_if_it_is_torn() {
    let whole = tempfile::tempdir().unwrap();
    generate_if_needed(whole.path(), &small(6), GO_ON, &|_| {}).unwrap();
    for name in ["scene.cache", "sky", "sky.0"] {
        let dir = tempfile::tempdir().unwrap();
        let after_one = || dir.path().join("images/frame_000.jpg").exists();
        assert!(generate_if_needed(dir.path(), &small(6), &after_one, &|_| {}).unwrap_err().is_interrupt());
        let torn = dir.path().join("unfinished").join(name);
        let mut bytes = fs::read(&torn).unwrap();
        bytes[100] ^= 1;
        fs::write(&torn, bytes).unwrap();
        generate_if_needed(dir.path(), &small(6), GO_ON, &|_| {}).unwrap();
        assert_eq!(files(dir.path()), files(whole.path()), "{name}");
    }
}

#[test]
fn another_configuration_replaces_the_city_and_nothing_else() {
    let dir = tempfile::tempdir().unwrap();
    generate_if_needed(dir.path(), &small(6), GO_ON, &|_| {}).unwrap();
    fs::write(dir.path().join("notes.txt"), b"mine").unwrap();
    fs::write(dir.path().join("images/other.jpg"), b"mine").unwrap();
    let summary = generate_if_needed(dir.path(), &CityConfig { frames: 1, ..small(6) }, GO_ON, &|_| {}).unwrap();
    assert!(!summary.reused && summary.frames == 1);
    let left = files(dir.path());
    assert!(left.contains_key("notes.txt") && left.contains_key("images/other.jpg"));
    assert!(left.contains_key("images/frame_000.jpg") && !left.contains_key("images/frame_001.jpg"));
}

#[test]
fn the_folder_of_another_is_left_alone() {
    for (name, text) in [("notes.txt", "mine"), ("city.json", "{\"name\": \"Paris\"}"), ("city.json", "no json")] {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join(name), text).unwrap();
        let words = generate_if_needed(dir.path(), &small(6), GO_ON, &|_| {}).unwrap_err().to_string();
        assert!(words.contains("left alone") && words.contains(name), "{words}");
        assert_eq!(files(dir.path()).len(), 1);
    }
}

#[test]
fn a_configuration_out_of_range_touches_nothing() {
    let dir = tempfile::tempdir().unwrap();
    let at = dir.path().join("city");
    assert!(generate_if_needed(&at, &CityConfig { frames: 0, ..small(1) }, GO_ON, &|_| {}).is_err());
    assert!(!at.exists());
}

#[test]
fn the_space_that_it_takes_is_what_is_not_there_yet() {
    let dir = tempfile::tempdir().unwrap();
    let (at, config) = (dir.path().join("city"), small(6));
    let needs = || folder::space(&at, &config).unwrap().map(|space| space.needs);
    let all = needs().unwrap();
    assert!(!folder::is_finished(&at, &config) && all > 215 * u64::from(config.triangles), "{all}");
    let after_one = || at.join("images/frame_000.jpg").exists();
    assert!(generate_if_needed(&at, &config, &after_one, &|_| {}).unwrap_err().is_interrupt());
    let there: u64 = files(&at).values().map(|bytes| bytes.len() as u64).sum();
    assert!(needs().unwrap() < all && needs().unwrap() >= all.saturating_sub(there), "{there} of {all} are there");
    generate_if_needed(&at, &config, GO_ON, &|_| {}).unwrap();
    assert!(needs().is_none() && folder::is_finished(&at, &config));
    assert!(folder::space(&at, &small(7)).unwrap().is_some());
    fs::write(dir.path().join("letter"), b"dear").unwrap();
    assert!(folder::space(dir.path(), &config).is_err());
}
