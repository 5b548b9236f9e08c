//! The keys that are said never to change a result change no byte of it.

use std::ffi::OsString;
use std::path::Path;
use std::sync::Arc;

use tempfile::TempDir;

use super::{outputs, run_here};
use crate::disk::{MemStore, Store};
use crate::pipeline::{NEVER_CHANGE_A_RESULT, load};

/// A city made on the run.
const CITY: &str = r#"
synth = { into = "city", city = { triangles = 5000, frames = 5, width = 48, height = 32, supersampling = 1 } }

[scene]
mesh = "city/mesh.ply"
images = "city/images"
poses = { format = "colmap", path = "city/sparse/0" }

[light]
mode = "known"
sun = [-0.456, -0.507, 0.731]
sky = [0.16, 0.19, 0.24]

[gather]
group = 2

[infer]
min_bins = 4

[run]
work = "work"
threads = 1
"#;

/// What each key is changed to; a new folder is in `dir`. `synth.into` takes the scene with it.
fn other(key: &str, dir: &Path) -> Vec<String> {
    let within = |key: &str, name: &str| format!("{key}={}", dir.join(name).display());
    match key {
        "synth.into" => vec![
            within("synth.into", "town"),
            within("scene.mesh", "town/mesh.ply"),
            within("scene.images", "town/images"),
            within("scene.poses.path", "town/sparse/0"),
        ],
        "run.work" => vec![within("run.work", "elsewhere")],
        "cast.tile" => vec!["cast.tile=8".to_owned()],
        "gather.group" => vec!["gather.group=3".to_owned()],
        "infer.batch" => vec!["infer.batch=7".to_owned()],
        "run.memory" => vec!["run.memory=1GiB".to_owned()],
        "run.threads" => vec!["run.threads=3".to_owned()],
        "run.grace" => vec!["run.grace=0".to_owned()],
        "run.verify" => vec!["run.verify=true".to_owned()],
        key => panic!("{key} is said never to change a result: change it here"),
    }
}

#[test]
fn what_never_changes_a_result_does_not() {
    let dir = TempDir::new().unwrap();
    let file = dir.path().join("p.toml");
    std::fs::write(&file, CITY).unwrap();
    let leaves = |sets: &[String]| {
        let sets: Vec<OsString> = sets.iter().map(OsString::from).collect();
        let store: Arc<dyn Store> = Arc::new(MemStore::new());
        run_here(Arc::clone(&store), &load(&file, &sets).unwrap()).unwrap();
        outputs(&*store)
    };
    for estimator in ["network", "fit"] {
        let as_ever = vec![format!("infer.estimator={estimator}")];
        let wanted = leaves(&as_ever);
        for key in NEVER_CHANGE_A_RESULT {
            let sets = [as_ever.clone(), other(key, dir.path())].concat();
            assert!(leaves(&sets) == wanted, "{estimator}: {key} changes a result");
        }
    }
}
