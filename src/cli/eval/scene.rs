//! `gonio eval scene`: how the materials of a finished run relight.

use std::path::PathBuf;

use serde_json::json;

use super::lines::{as_value, line};
use crate::after::{HeldOut, Judge, Judged, SUNS, judge};
use crate::cli::ending::{Answer, Ending};
use crate::cli::pipeline_args::PipelineArgs;
use crate::cli::print::{Lines, out};
use crate::render::pictures::PictureErrors;

/// Options of `eval scene`.
#[derive(Debug, clap::Args)]
pub(crate) struct Args {
    /// The pipeline of the finished run.
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// The truth, .npy [F,7], where it is known
    #[arg(long, value_name = "TRUTH.npy")]
    truth: Option<PathBuf>,
    /// Another table of materials, .npy [F,7], judged beside the run's
    #[arg(long, value_name = "OTHER.npy")]
    beside: Option<PathBuf>,
    /// Frames to render with the truth, spread over the flight
    #[arg(long, default_value_t = 3)]
    frames: usize,
    /// Write one JSON value
    #[arg(long)]
    json: bool,
}

/// Judges a finished run and shows the table.
pub(super) fn scene(args: &Args) -> Answer {
    let by = Judge { truth: args.truth.as_deref(), beside: args.beside.as_deref(), frames: args.frames };
    let (judged, held_out) = judge(&args.pipeline.load()?, by)?;
    let shown = if args.json {
        as_json(&judged, held_out.as_ref())
    } else {
        let truth = args.truth.is_some().then(|| as_table(&judged, args.frames));
        let tables: Vec<String> = truth.into_iter().chain(held_out.as_ref().map(held_out_table)).collect();
        tables.join("\n\n")
    };
    out(&shown)?;
    Ok(Ending::Done)
}

/// With a truth, a list of the estimates; without one, an object.
fn as_json(judged: &[Judged], held_out: Option<&HeldOut>) -> String {
    let compared = |errors: &PictureErrors| json!({ "psnr": errors.pixels.psnr(), "ssim": ssim(errors) });
    let held_out = held_out.map(|held_out| {
        let mut all = held_out.estimates.first().map_or(json!({}), |(_, errors)| compared(errors));
        all["frames"] = json!(held_out.frames);
        all["unread"] = held_out.unread.iter().map(|(name, _)| json!(name)).collect();
        all["estimates"] =
            held_out.estimates.iter().map(|(name, errors)| ((*name).to_owned(), compared(errors))).collect();
        all
    });
    if judged.is_empty() {
        return json!({ "held_out": held_out }).to_string();
    }
    let row = |(at, j): (usize, &Judged)| {
        let mut row = as_value(j.name, &j.errors);
        (row["same_light"], row["suns"]) = (json!(j.same), json!(j.suns));
        if let Some(held_out) = held_out.as_ref().filter(|_| at == 0) {
            row["held_out"] = held_out.clone();
        }
        row
    };
    json!(judged.iter().enumerate().map(row).collect::<Vec<_>>()).to_string()
}

fn ssim(errors: &PictureErrors) -> f64 {
    1.0 - 2.0 * errors.similarity.dssim()
}

fn held_out_table(HeldOut { frames, unread, estimates }: &HeldOut) -> String {
    let mut lines = Lines::default();
    lines.add(format!("{frames} photographs that were left out, in the light that was found; sRGB, by the mesh alone"));
    lines.add(format!("{:34}{:>8}{:>8}", "", "PSNR", "SSIM"));
    for (name, errors) in estimates {
        lines.add(format!("{name:34}{:>8.2}{:>8.4}", errors.pixels.psnr(), ssim(errors)));
    }
    unread.iter().for_each(|(name, why)| lines.add(format!("{name}: {why}")));
    lines.finish()
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
