//! `gonio check`: every problem of a pipeline file, and what its inputs look like.

use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use super::print::out;
use crate::run;

/// Options of `check`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
}

/// Checks a pipeline file, and opens its inputs.
pub(super) fn check(args: &Args) -> Answer {
    let pipeline = args.pipeline.load()?;
    let inputs = run::inputs(&pipeline)?;
    let lines = inputs.lines();
    lines.iter().try_for_each(|line| out(line))?;
    let unread = inputs.unread.len();
    match unread {
        0 => out(&format!("{}: no problems", args.pipeline.file.display()))?,
        _ => out(&format!("{}: no problems but those of the inputs", args.pipeline.file.display()))?,
    }
    Ok(match unread {
        0 => Ending::Done,
        all if all == inputs.frames => Ending::Broken,
        _ => Ending::Skipped,
    })
}
