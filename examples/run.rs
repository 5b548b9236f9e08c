//! Runs a pipeline file, and prints a table of the materials.
//!
//! ```text
//! cargo run --release --example run -- pipelines/demo.toml
//! ```
#![expect(clippy::print_stdout, reason = "an example shows its results")]

use std::error::Error;
use std::path::PathBuf;

use gonio::{Material, Progress, Result, Results, StopSignal, TriangleId, load, run};

fn main() -> Result<(), Box<dyn Error>> {
    let file = std::env::args_os().nth(1).map(PathBuf::from).ok_or("name a pipeline file")?;
    let pipeline = load(&file, &[])?;
    let report = run(&pipeline, &StopSignal::new(), &Progress::new())?;
    println!("{} triangles in {:.1} s", report.triangles.total, report.seconds);

    let results = Results::open(&pipeline)?;
    let materials: Vec<Material> =
        TriangleId::all(results.len()).filter_map(|triangle| results.material(triangle)).collect();
    println!("{:>8} {:>9} {:>9} {:>9} {:>9}", "", "materials", "mean", "least", "greatest");
    for (component, name) in Material::NAMES.into_iter().enumerate() {
        let values: Vec<f32> = materials.iter().map(|material| material.to_array()[component]).collect();
        let mean = values.iter().map(|value| f64::from(*value)).sum::<f64>() / values.len() as f64;
        let least = values.iter().copied().fold(f32::INFINITY, f32::min);
        let greatest = values.iter().copied().fold(f32::NEG_INFINITY, f32::max);
        println!("{name:>8} {:>9} {mean:>9.4} {least:>9.4} {greatest:>9.4}", values.len());
    }
    Ok(())
}
