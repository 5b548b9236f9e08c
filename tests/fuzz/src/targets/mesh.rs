//! Any file under the name of a PLY mesh.
#![no_main]

use std::fs;
use std::sync::LazyLock;

use gonio::internals::codec::meshes;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().unwrap());

fuzz_target!(|bytes: &[u8]| {
    let path = FOLDER.path().join("mesh.ply");
    fs::write(&path, bytes).unwrap();
    if let Ok(mesh) = meshes::read(&path, &|_| Ok(())) {
        assert!(!mesh.is_empty() && mesh.origin.is_finite() && mesh.positions.iter().all(|p| p.is_finite()));
        assert!(mesh.triangles.iter().flatten().all(|&i| (i as usize) < mesh.positions.len()));
        // A byte gives at most one corner, and a polygon of n corners n - 2 triangles.
        assert!(mesh.len() < bytes.len());
    }
});
