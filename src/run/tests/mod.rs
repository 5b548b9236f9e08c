//! A small run that is killed, refused, torn or without power at every step that it takes on the disk, one that rots, one that
//! two raced for, a phase that nobody foresaw, and the keys that change nothing.
//!
//! Where a fault may come at any step, several faults share the steps, so that each step has some of them: `GONIO_EVERY_STEP=1`
//! tries each at all steps.

mod ephemeris;
mod faults;
#[cfg(unix)]
mod inputs;
mod light;
mod mock;
#[cfg(target_os = "linux")]
mod power;
mod race;
#[cfg(unix)]
mod rot;
mod unchanged;

use std::path::Path;
use std::sync::Arc;

use tempfile::TempDir;

use super::execute::run_phases;
use crate::base::Result;
use crate::disk::{MemStore, Store};
use crate::flow::StopSignal;
use crate::phases::{PHASES, Progress, Report};
use crate::pipeline::{Pipeline, load};
use crate::stages::merge::{EVIDENCE, MATERIALS};
use crate::synth::city::{self, CityConfig};

/// What a run leaves for others.
const OUTPUTS: [&str; 4] = [MATERIALS, EVIDENCE, "export/scene.ply", "export/scene.glb"];

/// A small city, its photographs, and a pipeline file with a network of a few weights.
fn scene() -> (TempDir, Pipeline) {
    let dir = TempDir::new().unwrap();
    let config =
        CityConfig { triangles: 5000, frames: 4, width: 48, height: 32, supersampling: 1, ..Default::default() };
    city::write::generate(dir.path(), &config, &|| false).unwrap();
    let file = dir.path().join("p.toml");
    let model = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/models/conv4.onnx");
    let text = format!(
        "[scene]\nmesh = \"mesh.ply\"\nimages = \"images\"\nposes = {{ format = \"colmap\", path = \"sparse/0\" }}\n\
         [gather]\ngroup = 2\n[infer]\nmodel = {:?}\nbackend = \"embedded\"\nmin_bins = 4\n\
         [run]\nwork = \"work\"\nthreads = 1\n",
        model.display()
    );
    std::fs::write(&file, text).unwrap();
    let pipeline = load(&file, &[]).unwrap();
    (dir, pipeline)
}

/// The steps of the nth fault, of all of them one in so many.
fn steps(nth: usize, all: u64, one_in: usize) -> impl Iterator<Item = u64> {
    let one_in = if std::env::var_os("GONIO_EVERY_STEP").is_some() { 1 } else { one_in };
    (0..all).skip(nth % one_in).step_by(one_in)
}

/// The seeds to try: the one that the first variable names, or as many as the second says, or a few.
fn seeds(one: &str, many: &str, few: u64) -> std::ops::Range<u64> {
    let number = |name| std::env::var(name).ok().and_then(|text| text.parse::<u64>().ok());
    number(one).map_or(0..number(many).unwrap_or(few), |seed| seed..seed + 1)
}

fn run_here(store: Arc<dyn Store>, pipeline: &Pipeline) -> Result<(Report, Vec<String>)> {
    let progress = Progress::new();
    let report = run_phases(PHASES, store, pipeline, &StopSignal::new(), &progress)?;
    Ok((report, progress.take_notes()))
}

fn outputs(store: &dyn Store) -> Vec<Vec<u8>> {
    OUTPUTS.map(|name| store.open(name).unwrap().to_vec()).to_vec()
}

fn put(store: &MemStore, name: &str, bytes: &[u8]) {
    use std::io::Write;
    let mut draft = store.create(name).unwrap();
    draft.write_all(bytes).unwrap();
    draft.replace().unwrap();
}
