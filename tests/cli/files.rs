//! A small city to run on, and what runs leave.

use std::fs;
use std::path::{Path, PathBuf};
use std::sync::LazyLock;

use tempfile::TempDir;

use crate::ran::Ran;

/// Made once; every test copies it.
static CITY: LazyLock<PathBuf> = LazyLock::new(|| {
    let folder = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!("city-{}", env!("CARGO_PKG_VERSION")));
    fs::remove_dir_all(&folder).unwrap_or_default();
    let options = "--triangles 5000 --frames 10 --width 160 --height 120 --supersampling 1";
    Ran::gonio(Path::new("."), &format!("synth city --out {} {options}", folder.display())).ends(0);
    folder
});

/// A folder with a city (`mesh.ply`, `images`, `sparse/0`) and the pipeline file that is there to be copied, `p.toml`.
pub fn city() -> TempDir {
    let dir = TempDir::new().unwrap();
    copy(&CITY, dir.path());
    fs::copy(pipelines().join("colmap.toml"), dir.path().join("p.toml")).unwrap();
    dir
}

/// A pipeline file for the city that runs within a second: it needs no network.
pub const QUICK: &str = r#"
[scene]
mesh = "mesh.ply"
images = "images"
poses = { format = "colmap", path = "sparse/0" }
[gather]
group = 2
[infer]
estimator = "fit"
[light]
mode = "known"
sun = [-0.456, -0.507, 0.731]
[run]
work = "work"
memory = "1GiB"
threads = 2
"#;

/// A folder with a city and [`QUICK`] as `p.toml`.
pub fn quick() -> TempDir {
    let dir = city();
    fs::write(dir.path().join("p.toml"), QUICK).unwrap();
    dir
}

/// The folder of pipeline files.
pub fn pipelines() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("pipelines")
}

fn copy(from: &Path, to: &Path) {
    fs::create_dir_all(to).unwrap();
    for entry in fs::read_dir(from).unwrap().map(Result::unwrap) {
        let target = to.join(entry.file_name());
        if entry.file_type().unwrap().is_dir() {
            copy(&entry.path(), &target);
        } else {
            fs::copy(entry.path(), target).unwrap();
        }
    }
}

/// The bytes of all that a run leaves for others.
pub fn outputs(work: &Path) -> Vec<Vec<u8>> {
    let names = ["materials.npy", "evidence.npy", "export/scene.ply", "export/scene.glb"];
    names.map(|name| fs::read(work.join(name)).unwrap()).to_vec()
}

/// The run's report.
pub fn report(work: &Path) -> serde_json::Value {
    serde_json::from_slice(&fs::read(work.join("report.json")).unwrap()).unwrap()
}
