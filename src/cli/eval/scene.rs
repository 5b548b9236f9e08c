//! `gonio eval scene`: how the materials of a finished run relight.

use std::path::PathBuf;

use serde_json::json;

use super::lines::{as_value, line};
use crate::after::{Judged, SUNS, judge};
use crate::cli::ending::{Answer, Ending};
use crate::cli::pipeline_args::PipelineArgs;
use crate::cli::print::{Lines, out};

/// Options of `eval scene`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The pipeline of the finished run.
    #[command(flatten)]
    pipeline: PipelineArgs,
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

/// Judges a finished run and shows the table.
pub(super) fn scene(args: &Args) -> Answer {
    let judged = judge(&args.pipeline.load()?, &args.truth, args.frames)?;
    out(&if args.json { as_json(&judged) } else { as_table(&judged, args.frames) })?;
    Ok(Ending::Done)
}

fn as_json(judged: &[Judged]) -> String {
    let row = |j: &Judged| {
        let mut row = as_value(j.name, &j.errors);
        (row["same_light"], row["suns"]) = (json!(j.same), json!(j.suns));
        row
    };
    json!(judged.iter().map(row).collect::<Vec<_>>()).to_string()
}

fn as_table(judged: &[Judged], frames: usize) -> String {
    let mut lines = Lines::default();
    let count = judged.first().map_or(0, |j| j.errors.count);
    lines.add(format!("mean absolute errors over {count} triangles; PSNR, dB, of {frames} frames"));
    let suns: String =
        SUNS.iter().map(|(elevation, azimuth)| format!("{:>9}", format!("{elevation}/{azimuth}"))).collect();
    lines.add(format!("{:34}{:>8}{:>8}{:>8}{:>9}{suns}", "", "kd", "ks", "r", "same sun"));
    for j in judged {
        let same = j.same.map_or("unknown".to_owned(), |same| format!("{same:.2}"));
        let suns: String = j.suns.iter().map(|psnr| format!("{psnr:>9.2}")).collect();
        lines.add(format!("{}{same:>9}{suns}", line(j.name, &j.errors)));
    }
    lines.finish()
}
