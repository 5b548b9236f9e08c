//! `gonio export`: the exports of a finished run, written again.

use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use super::print::out;
use crate::after;

/// Options of `export`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
}

/// Writes what is missing and shows the paths of all exports.
pub(super) fn export(args: &Args) -> Answer {
    let written = after::export(&args.pipeline.load()?)?;
    written.iter().try_for_each(|path| out(&path.display().to_string()))?;
    Ok(Ending::Done)
}
