//! How pipeline files are read: the words of problems, every key's effect, the template.

mod coordinates;
mod keys;
mod load;
mod short;
mod template;

use std::ffi::OsString;
use std::fs;

use tempfile::TempDir;

use super::Pipeline;

/// The pipeline file that is there to be copied.
const TEMPLATE: &str = include_str!("../../../pipelines/colmap.toml");

/// The demonstration.
const DEMO: &str = include_str!("../../../pipelines/demo.toml");

/// A folder with the inputs that the template names.
fn scene() -> TempDir {
    let dir = TempDir::new().unwrap();
    for folder in ["images", "sparse/0"] {
        fs::create_dir_all(dir.path().join(folder)).unwrap();
    }
    for file in ["mesh.ply", "sparse/0/cameras.bin", "sparse/0/images.bin"] {
        fs::write(dir.path().join(file), "").unwrap();
    }
    dir
}

/// Loads a file of this text from a folder; its problems without the folder's path.
fn load_text(dir: &TempDir, text: &[u8], sets: &[&str]) -> Result<Pipeline, String> {
    let file = dir.path().join("p.toml");
    fs::write(&file, text).unwrap();
    let sets: Vec<OsString> = sets.iter().map(OsString::from).collect();
    super::load(&file, &sets)
        .map_err(|problems| problems.to_string().replace(&format!("{}/", dir.path().display()), ""))
}
