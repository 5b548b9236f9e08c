//! Any pipeline file, and any arguments over it: what follows a byte 0 is one `--set`.

use std::ffi::OsString;
use std::fs;

use gonio::load;

use super::Target;
use crate::input;

/// A byte may be a value with its position, and each wrong one a problem in words.
pub const PIPELINE: Target = Target { name: "pipeline", read, may_hold: |bytes| (8 << 20) + 4096 * bytes };

fn read(bytes: &[u8]) -> bool {
    let mut parts = bytes.split(|&b| b == 0);
    // The files of a model, which are not opened; a mesh may be any file.
    let model = input::folder().join("model");
    if !model.is_dir() {
        fs::create_dir_all(&model).unwrap();
        ["cameras.bin", "images.bin"].iter().for_each(|name| fs::write(model.join(name), []).unwrap());
    }
    let path = input::file("any.toml", parts.next().unwrap_or_default());
    let sets: Vec<OsString> = parts.map(|set| String::from_utf8_lossy(set).into_owned().into()).collect();
    match load(&path, &sets) {
        Ok(_) => true,
        Err(problems) => {
            let words = problems.to_string();
            assert!(!problems.list.is_empty() && !words.is_empty());
            assert!(!words.contains(|c: char| c.is_control() && c != '\n'), "{words:?}");
            false
        }
    }
}
