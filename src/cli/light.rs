//! `gonio light`: exposures and light are found, and nothing else is done.

use super::ending::Answer;
use super::found::rows;
use super::pipeline_args::PipelineArgs;
use super::print::{Lines, clock};
use super::run::shown;
use crate::base::Error;
use crate::phases::light::{DOME, LIGHT};
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
        let words = "nothing is to be found: set [light] mode = \"estimate\" or \"ephemeris\", or [decode] exposure = \"solve\"";
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
