//! `gonio check`: every problem of a pipeline file.

use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use super::print::out;

/// Options of `check`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
}

/// Checks a pipeline file.
pub(super) fn check(args: &Args) -> Answer {
    args.pipeline.load()?;
    out(&format!("{}: no problems", args.pipeline.file.display()))?;
    Ok(Ending::Done)
}
