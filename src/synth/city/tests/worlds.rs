//! What a configuration promises of the world: the plain one stays what it was, suns share out the flight, and what is handed out of
//! the real one has its own truth.

use std::fs;

use super::folder::{GO_ON, files};
use super::small;
use crate::codec::images::taken;
use crate::codec::meshes;
use crate::codec::tables::npy;
use crate::synth::city::{CityConfig, Version, World, each_block, generate_if_needed};

/// The digest of all files of a city, names and bytes.
fn digest(config: &CityConfig) -> String {
    let dir = tempfile::tempdir().unwrap();
    generate_if_needed(dir.path(), config, GO_ON, &|_| {}).unwrap();
    let mut hasher = blake3::Hasher::new();
    for (name, bytes) in files(dir.path()) {
        hasher.update(name.as_bytes()).update(&(bytes.len() as u64).to_le_bytes()).update(&bytes);
    }
    hasher.finalize().to_hex()[..16].to_owned()
}

/// Sines are those of the system's library, so the bytes are those of one system.
#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_plain_city_is_what_it_was() {
    assert_eq!(digest(&small(4)), "37cab1f7cc21819d");
}

#[test]
fn two_suns_give_two_lights() {
    let made = |suns: Vec<[f64; 2]>, sun_azimuth_deg: f64| {
        let dir = tempfile::tempdir().unwrap();
        let config = CityConfig { frames: 4, suns, sun_elevation_deg: 40.0, sun_azimuth_deg, ..small(4) };
        generate_if_needed(dir.path(), &config, GO_ON, &|_| {}).unwrap();
        (files(dir.path()), dir)
    };
    let ((first, _a), (second, _b)) = (made(Vec::new(), 0.0), made(Vec::new(), 150.0));
    let (both, dir) = made(vec![[40.0, 0.0], [40.0, 150.0]], 7.0);
    // Photographs of one sun have no EXIF, so pixels are compared.
    let pixels = |bytes: &Vec<u8>| image::load_from_memory(bytes).unwrap().to_rgb8().into_raw();
    for (k, alike) in [(0, &first), (1, &first), (2, &second), (3, &second)] {
        let name = format!("images/frame_00{k}.jpg");
        assert_eq!(pixels(&both[&name]), pixels(&alike[&name]), "{name}");
        assert_ne!(pixels(&first[&name]), pixels(&second[&name]), "{name}");
    }
    for name in ["mesh.ply", "truth/materials.npy", "sparse/0/images.bin"] {
        assert_eq!(both[name], first[name], "{name}");
    }
    let truth: serde_json::Value = serde_json::from_slice(&both["truth/light.json"]).unwrap();
    let alone: serde_json::Value = serde_json::from_slice(&second["truth/light.json"]).unwrap();
    assert_eq!((&truth["suns"][1], &truth["sky"]), (&alone["sun"], &alone["sky"]));
    for (name, told) in truth["frames"].as_object().unwrap() {
        let time = taken(&dir.path().join("images").join(name)).unwrap().time.unwrap().to_string();
        let sun = u64::from(name.as_str() >= "frame_002.jpg");
        assert_eq!((&told["sun"], &told["time"]), (&sun.into(), &time.into()), "{name}");
    }
    assert!(fs::read_dir(dir.path().join("images")).unwrap().count() == 4);
}

fn real(seed: u64) -> CityConfig {
    CityConfig { frames: 2, supersampling: 1, world: World::Real, ..small(seed) }
}

#[test]
fn threads_do_not_change_a_byte_of_the_real_world() {
    let made = |threads: usize| {
        let dir = tempfile::tempdir().unwrap();
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| generate_if_needed(dir.path(), &real(5), GO_ON, &|_| {})).unwrap();
        // Interrupted after its first photograph, it goes on to the same bytes.
        let other = tempfile::tempdir().unwrap();
        let after_one = || other.path().join("images/frame_000.jpg").exists();
        pool.install(|| generate_if_needed(other.path(), &real(5), &after_one, &|_| {})).unwrap_err();
        pool.install(|| generate_if_needed(other.path(), &real(5), GO_ON, &|_| {})).unwrap();
        assert_eq!(files(dir.path()), files(other.path()));
        files(dir.path())
    };
    let (one, two) = (made(1), made(2));
    assert!(one == two && one.len() == 9, "{:?}", one.keys());
}

#[test]
fn what_is_handed_out_has_the_truth_of_what_was_photographed_there() {
    let (dir, config) = (tempfile::tempdir().unwrap(), real(7));
    generate_if_needed(dir.path(), &config, GO_ON, &|_| {}).unwrap();
    let mesh = meshes::read(&dir.path().join("mesh.ply"), &|_| Ok(())).unwrap();
    let truth = npy::read_rows::<7>(&dir.path().join("truth/materials.npy")).unwrap();
    assert_eq!(mesh.len(), truth.len());
    let mut town = Vec::new();
    each_block(&config, Version::Town, &mut |block| {
        let solid = (0..block.triangles.len()).filter(|t| !block.substances[*t].is_clear());
        town.extend(solid.map(|t| {
            let [a, b, c] = block.triangles[t].map(|v| block.vertices[v as usize]);
            ((a + b + c) / 3.0, block.materials[t].kd)
        }));
        Ok(())
    })
    .unwrap();
    // Whether a triangle's truth is that of the nearest of the town, but for its texture.
    let agrees = |t: usize, row: &[f32; 7]| {
        let middle = mesh.corners(crate::base::ids::TriangleId::at(t)).into_iter().sum::<glam::Vec3>() / 3.0;
        let at = mesh.origin + middle.as_dvec3();
        let near = town.iter().min_by(|a, b| a.0.distance_squared(at).total_cmp(&b.0.distance_squared(at))).unwrap();
        (0..3).all(|c| (row[c] / near.1[c]).ln().abs() < 0.35)
    };
    let known: Vec<usize> = (0..truth.len()).filter(|t| truth[*t][0].is_finite()).step_by(7).collect();
    assert!(truth.iter().all(|row| row[0].is_finite() == row[6].is_finite()));
    let clear = truth.iter().filter(|row| row[0].is_nan()).count();
    assert!(clear > truth.len() / 200 && clear < truth.len() / 4, "{clear} of {}", truth.len());
    let right = known.iter().filter(|t| agrees(**t, &truth[**t])).count();
    let shifted = known.iter().filter(|t| agrees(**t, &truth[(**t + 500) % truth.len()])).count();
    assert!(right * 10 > known.len() * 8 && shifted * 10 < known.len() * 5, "{right}, {shifted} of {}", known.len());
}
