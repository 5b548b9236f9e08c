//! Any two files under the names of a binary COLMAP model. The first two bytes of the input say where they part.
#![no_main]

use std::fs;
use std::path::{Component, Path};
use std::sync::LazyLock;

use gonio::internals::codec::poses::{self, COLMAP};
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().unwrap());

fuzz_target!(|bytes: &[u8]| {
    let Some((length, rest)) = bytes.split_first_chunk() else { return };
    let (cameras, images) = rest.split_at(rest.len().min(u16::from_le_bytes(*length).into()));
    fs::write(FOLDER.path().join("cameras.bin"), cameras).unwrap();
    fs::write(FOLDER.path().join("images.bin"), images).unwrap();
    for frame in poses::read(&COLMAP, FOLDER.path()).unwrap_or_default() {
        assert!(Path::new(&frame.name).components().all(|c| matches!(c, Component::Normal(_))), "{:?}", frame.name);
        assert!(frame.pose.translation.is_finite() && frame.pose.rotation.is_normalized());
        assert!(frame.camera.width > 0 && frame.camera.height > 0);
    }
});
