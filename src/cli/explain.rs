//! `gonio explain`: what the next run would do over, as a table.

use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use super::print::{Lines, out};
use crate::phases::{Cause, FrameChange, FrameInput};
use crate::run::{self, Explanation, PhaseExplanation};

/// Options of `explain`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
}

/// Shows what the next run would do over.
pub(super) fn explain(args: &Args) -> Answer {
    out(&table(&run::explain(&args.pipeline.load()?)?))?;
    Ok(Ending::Done)
}

/// The causes of a phase that are listed.
const LISTED: usize = 20;

/// The explanation as lines of text.
fn table(explanation: &Explanation) -> String {
    let mut lines = Lines::default();
    if explanation.is_nothing() {
        lines.add("nothing is done over: all is there");
    }
    for phase in explanation.phases.iter().filter(|_| !explanation.is_nothing()) {
        lines.row(phase.noun, count(phase));
        phase.causes.iter().take(LISTED).for_each(|cause| lines.add(format!("  {}", words(cause))));
        if phase.causes.len() > LISTED {
            lines.add(format!("  and {} more", phase.causes.len() - LISTED));
        }
    }
    if let Some(moved) = &explanation.moved {
        lines.row("light", stays(moved));
    }
    lines.finish()
}

/// What is said of a light that photographs contradict.
pub(super) fn stays(moved: &str) -> String {
    format!("stays as it was found, but {moved}; `gonio light PIPELINE --again` finds it anew")
}

fn count(PhaseExplanation { total, again, .. }: &PhaseExplanation) -> String {
    match (total, again) {
        (None, 0) => "not known before the phases above are done".to_owned(),
        (None, again) => format!("at least {again}"),
        (Some(_), 0) => "none".to_owned(),
        (Some(total), again) => format!("{again} of {total}"),
    }
}

/// A cause in words.
pub(super) fn words(cause: &Cause) -> String {
    match cause {
        Cause::New => "not done yet".to_owned(),
        Cause::FrameNew { frame } => format!("{frame} is new"),
        Cause::FrameGone { frame } => format!("{frame} is no longer among the poses"),
        Cause::Frame { frame, input, change } => {
            let input = match input {
                FrameInput::Image => "image",
                FrameInput::Mask => "mask",
                FrameInput::Pose => "pose",
                FrameInput::Gain => "gain",
                FrameInput::Light => "light",
            };
            match change {
                FrameChange::Came => format!("{frame} has a {input} now"),
                FrameChange::Went => format!("{frame} no longer has a {input}"),
                FrameChange::Content => format!("the {input} of {frame} changed"),
                FrameChange::Readable => format!("the {input} of {frame} can be read now"),
                FrameChange::Unreadable => format!("the {input} of {frame} can no longer be read"),
                FrameChange::Fits => format!("{frame} fits under [run] memory now"),
                FrameChange::TooLarge => format!("{frame} no longer fits under [run] memory"),
            }
        }
        Cause::Setting { key, before, now } if before.len() + now.len() < 80 => {
            format!("{key} was {before} and is {now}")
        }
        Cause::Setting { key, .. } | Cause::Input { key } => format!("{key} changed"),
        Cause::Format => "this gonio writes another format".to_owned(),
        Cause::Upstream => "made of what is done over above".to_owned(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::PhaseName;

    #[test]
    fn every_phase_is_told_with_its_causes() {
        let phase = |name, noun, total, again, causes: &[Cause]| PhaseExplanation {
            name,
            noun,
            total,
            again,
            causes: causes.to_vec(),
        };
        let (frame, input, change) = ("a.jpg".to_owned(), FrameInput::Image, FrameChange::Content);
        let explanation = Explanation {
            phases: vec![
                phase(PhaseName::Cast, "frames", Some(10), 2, &[Cause::Frame { frame, input, change }]),
                phase(PhaseName::Infer, "shards", None, 0, &[Cause::Upstream]),
                phase(PhaseName::Merge, "tables", Some(1), 1, &[Cause::Upstream]),
                phase(PhaseName::Export, "exports", Some(2), 0, &[]),
            ],
            moved: Some("the sun went down".into()),
        };
        insta::assert_snapshot!(table(&explanation), @r"
        frames         2 of 10
          the image of a.jpg changed
        shards         not known before the phases above are done
          made of what is done over above
        tables         1 of 1
          made of what is done over above
        exports        none
        light          stays as it was found, but the sun went down; `gonio light PIPELINE --again` finds it anew
        ");
        assert_eq!(table(&Explanation::default()), "nothing is done over: all is there");
    }
}
