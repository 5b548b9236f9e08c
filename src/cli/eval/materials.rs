//! `gonio eval materials`: how far an estimate of materials is from the truth.

use std::path::PathBuf;

use serde_json::json;

use super::lines::{as_value, line};
use crate::base::{Error, Result};
use crate::cli::ending::{Answer, Ending};
use crate::cli::print::{Lines, out};
use crate::codec::tables::npy;
use crate::render::metrics::{MaterialErrors, TRAINING_MEAN, compare, diffuse_guess, within};
use crate::scene::Material;
use crate::scene::evidence::{Evidence, Filled};

/// Options of `eval materials`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The truth, .npy [F,7]
    #[arg(value_name = "TRUTH.npy")]
    truth: PathBuf,
    /// The estimate, .npy [F,7]
    #[arg(value_name = "ESTIMATE.npy")]
    estimate: PathBuf,
    /// The evidence behind the estimate; evidence.npy beside it if not named
    #[arg(long, value_name = "FILE.npy")]
    evidence: Option<PathBuf>,
    /// Write one JSON object
    #[arg(long)]
    json: bool,
}

/// Measures an estimate and shows the table.
pub(super) fn materials(options: &Args) -> Answer {
    let read = |path: &PathBuf| -> Result<Vec<Material>> {
        Ok(npy::read_rows::<{ Material::LEN }>(path)?.into_iter().map(Material::from).collect())
    };
    let (truth, estimate) = (read(&options.truth)?, read(&options.estimate)?);
    let path = options.evidence.clone().unwrap_or_else(|| options.estimate.with_file_name("evidence.npy"));
    let evidence: Vec<Evidence> = npy::read_rows(&path)?.into_iter().map(Evidence::from_array).collect();
    let seen: Vec<bool> = evidence.iter().map(|e| e.filled == Filled::Observed).collect();
    if !seen.contains(&true) {
        return Err(Error::malformed(path, "no triangle was seen: there is nothing to measure").into());
    }
    let mean: Vec<[f32; 3]> = evidence.iter().map(|e| e.mean_radiance).collect();
    let deviation: Vec<_> = evidence.iter().map(|e| e.deviation).collect();
    let sure = within(&truth, &estimate, &deviation, &seen);
    let rows = [
        ("estimate", compare(&truth, &estimate, &seen)?),
        ("mean radiance as kd, ks 0, r 0.5", compare(&truth, &diffuse_guess(&mean), &seen)?),
        ("training mean, 0.5 throughout", compare(&truth, &vec![TRAINING_MEAN; truth.len()], &seen)?),
    ];
    out(&if options.json { as_json(&rows, sure) } else { as_table(&rows, sure, truth.len()) })?;
    Ok(Ending::Done)
}

fn as_table(rows: &[(&str, MaterialErrors)], sure: Option<[f64; 3]>, triangles: usize) -> String {
    let mut lines = Lines::default();
    let errors = &rows[0].1;
    lines.add(format!("mean absolute errors over {} of {triangles} triangles", errors.count));
    if errors.missing > 0 {
        lines.add(format!("{} more were seen and have no estimate", errors.missing));
    }
    lines.add(format!("{:34}{:>8}{:>8}{:>8}", "", "kd", "ks", "r"));
    for (name, e) in rows {
        lines.add(line(name, e));
    }
    if let Some([kd, ks, r]) = sure {
        lines.add(format!("{:34}{:>7.1}%{:>7.1}%{:>7.1}%", "within one deviation", 100.0 * kd, 100.0 * ks, 100.0 * r));
    }
    lines.finish()
}

fn as_json(rows: &[(&str, MaterialErrors)], sure: Option<[f64; 3]>) -> String {
    let rows = rows.iter().map(|(name, e)| as_value(name, e)).collect::<Vec<_>>();
    json!({ "estimates": rows, "within_one_deviation": sure }).to_string()
}
