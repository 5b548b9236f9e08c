//! `gonio eval`: how far an estimate is from the truth.

mod images;

use std::path::PathBuf;

use clap::{Args, Subcommand};
use serde_json::{Value, json};

pub use images::{Images, images};

use super::args::PipelineArgs;
use super::report::Lines;
use crate::base::{Error, Result};
use crate::codec::npy;
use crate::pipeline::Pipeline;
use crate::pipeline::judge::{Judged, SUNS, judge};
use crate::render::metrics::{MaterialErrors, TRAINING_MEAN, compare, diffuse_guess, within};
use crate::scene::Material;
use crate::scene::evidence::{Evidence, Filled};

/// What is measured.
#[derive(Debug, Subcommand)]
pub enum Eval {
    /// PSNR, NRMSE, DSSIM and MAE of pictures, one by one and all together
    ///
    /// Samples of 8 and 16 bits are taken to be sRGB, floating-point ones to be linear; all are clipped to [0, 1]. PSNR and
    /// SSIM are of a range of 1, NRMSE is over the root mean square of the truth, and DSSIM is (1 - SSIM) / 2 with even
    /// windows of 7 x 7 pixels. Folders are compared by the names of the files in them; what has no partner, or cannot be
    /// compared with it, is listed, and the exit code is then 3.
    Images(Images),
    /// Mean absolute errors of kd, ks and roughness over the triangles that were seen, beside two trivial guesses
    Materials(Materials),
    /// The same, and how well frames relight, under the sun of the photographs and four others
    Scene {
        /// Of which finished run.
        #[command(flatten)]
        pipeline: PipelineArgs,
        /// How.
        #[command(flatten)]
        options: Judging,
    },
}

/// Options of `eval scene`.
#[derive(Debug, Args)]
pub struct Judging {
    /// The truth, .npy [F,7]
    #[arg(long, value_name = "TRUTH.npy")]
    truth: PathBuf,
    /// Frames to render, spread over the flight
    #[arg(long, default_value_t = 3)]
    frames: usize,
    /// Write one JSON object
    #[arg(long)]
    json: bool,
}

/// Options of `eval materials`.
#[derive(Debug, Args)]
pub struct Materials {
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

/// Measures it, and gives the table.
///
/// # Errors
/// Files that cannot be read, or whose rows are not as many.
pub fn materials(options: &Materials) -> Result<String> {
    let read = |path: &PathBuf| -> Result<Vec<Material>> {
        Ok(npy::read_rows::<{ Material::LEN }>(path)?.into_iter().map(Material::from).collect())
    };
    let (truth, estimate) = (read(&options.truth)?, read(&options.estimate)?);
    let path = options.evidence.clone().unwrap_or_else(|| options.estimate.with_file_name("evidence.npy"));
    let evidence: Vec<Evidence> = npy::read_rows(&path)?.into_iter().map(Evidence::from_array).collect();
    let seen: Vec<bool> = evidence.iter().map(|e| e.filled == Filled::Observed).collect();
    if !seen.contains(&true) {
        return Err(Error::malformed(path, "no triangle was seen: there is nothing to measure"));
    }
    let mean: Vec<[f32; 3]> = evidence.iter().map(|e| e.mean_radiance).collect();
    let deviation: Vec<_> = evidence.iter().map(|e| e.deviation).collect();
    let sure = within(&truth, &estimate, &deviation, &seen);
    let rows = [
        ("estimate", compare(&truth, &estimate, &seen)?),
        ("mean radiance as kd, ks 0, r 0.5", compare(&truth, &diffuse_guess(&mean), &seen)?),
        ("training mean, 0.5 throughout", compare(&truth, &vec![TRAINING_MEAN; truth.len()], &seen)?),
    ];
    Ok(if options.json { as_json(&rows, sure) } else { as_table(&rows, sure, truth.len()) })
}

/// Judges a finished run, and gives the table.
///
/// # Errors
/// No finished run, a truth that cannot be read.
pub fn scene(pipeline: &Pipeline, options: &Judging) -> Result<String> {
    let judged = judge(pipeline, &options.truth, options.frames)?;
    if options.json {
        let row = |j: &Judged| {
            let mut row = errors(j.name, &j.errors);
            (row["same_light"], row["suns"]) = (json!(j.same), json!(j.suns));
            row
        };
        return Ok(json!(judged.iter().map(row).collect::<Vec<_>>()).to_string());
    }
    let mut lines = Lines::default();
    lines.add(format!(
        "mean absolute errors over {} triangles; PSNR, dB, of {} frames",
        judged[0].errors.count, options.frames
    ));
    let suns: String =
        SUNS.iter().map(|(elevation, azimuth)| format!("{:>9}", format!("{elevation}/{azimuth}"))).collect();
    lines.add(format!("{:34}{:>8}{:>8}{:>8}{:>9}{suns}", "", "kd", "ks", "r", "same sun"));
    for j in &judged {
        let same = j.same.map_or("unknown".to_owned(), |same| format!("{same:.2}"));
        let suns: String = j.suns.iter().map(|psnr| format!("{psnr:>9.2}")).collect();
        lines.add(format!("{}{same:>9}{suns}", line(j.name, &j.errors)));
    }
    Ok(lines.finish())
}

/// What an estimate is off by, as a line of a table.
fn line(name: &str, e: &MaterialErrors) -> String {
    format!("{name:34}{:>8.4}{:>8.4}{:>8.4}", e.kd, e.ks, e.r)
}

/// The same as JSON.
fn errors(name: &str, e: &MaterialErrors) -> Value {
    json!({ "what": name, "kd": e.kd, "ks": e.ks, "r": e.r, "triangles": e.count, "missing": e.missing })
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
    let rows = rows.iter().map(|(name, e)| errors(name, e)).collect::<Vec<_>>();
    json!({ "estimates": rows, "within_one_deviation": sure }).to_string()
}
