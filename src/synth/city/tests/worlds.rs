//! What a configuration promises of the world: the plain one stays what it was, suns share out the flight.

use std::fs;

use super::folder::{GO_ON, files};
use super::small;
use crate::codec::images::taken;
use crate::synth::city::{CityConfig, generate_if_needed};

/// The digest of all files of a city, names and bytes.
fn digest(config: &CityConfig) -> String {
    let dir = tempfile::tempdir().unwrap();
    generate_if_needed(dir.path(), config, GO_ON).unwrap();
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
        generate_if_needed(dir.path(), &config, GO_ON).unwrap();
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
