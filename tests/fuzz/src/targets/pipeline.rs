//! Any pipeline file, and any arguments over it: what follows a byte 0 is one `--set`.
#![no_main]

use std::fs;
use std::sync::LazyLock;

use gonio::load;
use libfuzzer_sys::fuzz_target;
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().unwrap());

fuzz_target!(|bytes: &[u8]| {
    let mut parts = bytes.split(|&b| b == 0);
    let path = FOLDER.path().join("any.toml");
    fs::write(&path, parts.next().unwrap_or_default()).unwrap();
    let sets: Vec<String> = parts.map(|set| String::from_utf8_lossy(set).into_owned()).collect();
    if let Err(problems) = load(&path, &sets) {
        assert!(!problems.list.is_empty() && !problems.to_string().is_empty());
    }
});
