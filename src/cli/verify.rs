//! `gonio verify`: whether a run's folder is as it was written, and the inputs as they were.

use super::ending::{Answer, Ending};
use super::explain::words;
use super::pipeline_args::PipelineArgs;
use super::print::{Lines, out};
use crate::base::units::Bytes;
use crate::pipeline::Pipeline;
use crate::run::{self, Verified};

/// Options of `verify`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// Compare the mesh, the poses, the photographs, the masks and the model with what was made of them, too
    #[arg(long)]
    inputs: bool,
}

/// Names what is rotten, or says in one line that nothing is.
pub(super) fn verify(args: &Args) -> Answer {
    let pipeline = args.pipeline.load()?;
    let verified = run::verify(&pipeline, args.inputs)?;
    out(&if verified.is_sound() { sound(&verified, &pipeline, args.inputs) } else { rotten(&verified, &pipeline) })?;
    Ok(if verified.is_sound() { Ending::Done } else { Ending::Broken })
}

fn sound(Verified { held, finished, .. }: &Verified, pipeline: &Pipeline, inputs: bool) -> String {
    let (work, file) = (pipeline.run.work.display(), pipeline.file.display());
    let inputs = if inputs { "; the inputs are those that they were made of" } else { "" };
    let rest = if *finished { String::new() } else { format!("; not finished: `gonio run {file}` goes on from here") };
    let (units, files, bytes) = (held.units, held.files, Bytes(held.bytes));
    format!("{work}: {units} units in {files} files, {bytes}, all as they were written{inputs}{rest}")
}

fn rotten(Verified { held, changed, unread, .. }: &Verified, pipeline: &Pipeline) -> String {
    let (work, file) = (&pipeline.run.work, pipeline.file.display());
    let mut lines = Lines::default();
    for rotten in &held.rotten {
        let unit = rotten.unit.as_ref().map_or_else(String::new, |unit| format!(" ({unit})"));
        lines.add(format!("rotten  {}{unit}: {}", work.join(&rotten.file).display(), rotten.why));
    }
    for input in changed {
        lines.add(format!("changed {} ({}): {}", input.input.display(), input.unit, words(&input.cause)));
    }
    for why in unread {
        lines.add(format!("unread  {why}; inputs that come after it were not compared"));
    }
    if !held.rotten.is_empty() {
        let count = held.rotten.len();
        lines.add(format!("{count} rotten: `gonio run {file} --set run.verify=true` makes it again"));
    }
    if !changed.is_empty() {
        let count = changed.len();
        lines.add(format!("{count} changed: put it back, or `gonio run {file}` does over what was made of it"));
    }
    lines.finish()
}
