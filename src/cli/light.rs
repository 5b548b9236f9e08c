//! `gonio light`: exposures and light are found, and nothing else is done.

use super::ending::Answer;
use super::explain::stays;
use super::pipeline_args::PipelineArgs;
use super::print::{Lines, clock};
use super::run::shown;
use crate::base::Error;
use crate::phases::light::{DOME, LIGHT};
use crate::phases::{LightReport, Report};
use crate::run::find_light;

/// Options of `light`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// Find anew what was found before, and is frozen
    #[arg(long)]
    again: bool,
    /// Write events to standard output, one JSON object a line, and nothing else
    #[arg(long)]
    json: bool,
}

/// Finds exposures and light of a pipeline's photographs and shows them.
pub(super) fn light(args: &Args) -> Answer {
    let pipeline = args.pipeline.load()?;
    if !pipeline.is_looked_at() {
        let words = "nothing is to be found: set [light] mode = \"estimate\" or [decode] exposure = \"solve\"";
        return Err(Error::invalid(words).into());
    }
    let work = &pipeline.run.work;
    let again = args.again;
    shown(&pipeline, args.json, &|pipeline, stop, progress| find_light(pipeline, again, stop, progress), &|report| {
        let mut lines = Lines::default();
        rows(&mut lines, report);
        lines.row("time", clock(report.seconds));
        lines.row("written", work.join(LIGHT).display().to_string());
        if report.light.as_ref().is_some_and(|light| !light.words.is_empty()) {
            lines.row("sky", work.join(DOME).display().to_string());
        }
        lines.finish()
    })
}

/// Shows what a report says of exposures and light.
pub(super) fn rows(lines: &mut Lines, report: &Report) {
    let Some(light) = &report.light else { return };
    let LightReport { sun, sun_degrees, color, sky, white, turned, words, moved, gains, gain_range, untied } = light;
    let three = |v: &[f32; 3]| v.map(|v| format!("{v:.3}")).join(" ");
    if let Some([x, y, z]) = sun {
        lines.row("sun", format!("[{x:.4}, {y:.4}, {z:.4}] within {sun_degrees:.1} degrees, turned {turned:.2}"));
        lines.row("light", format!("sun {}, sky {}; white {white:.2}", three(color), three(sky)));
    }
    if sun.is_some() {
        lines.row("", words.clone());
    } else if !words.is_empty() {
        lines.row("light", format!("no sun was found: {words}"));
    }
    if let Some(moved) = moved {
        lines.row("", stays(moved));
    }
    if *gains > 0 || !untied.is_empty() {
        let [low, high] = gain_range;
        let left = if untied.is_empty() { String::new() } else { format!("; {} not told", untied.len()) };
        lines.row("exposure", format!("gains {low:.2} to {high:.2} of {gains} frames{left}"));
    }
}
