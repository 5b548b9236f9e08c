//! What a run will take, as a table.

use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use super::print::{Lines, clock, out, short};
use crate::base::units::Bytes;
use crate::disk::Space;
use crate::run::{self, Foreseen, PlannedPhase};

/// Options of `plan`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
}

/// Shows what a run will take, and refuses one that cannot work.
pub(super) fn plan(args: &Args) -> Answer {
    let foreseen = run::plan(&args.pipeline.load()?)?;
    out(&table(&foreseen))?;
    foreseen.works()?;
    Ok(Ending::Done)
}

/// The plan as lines of text.
fn table(Foreseen { plan, space, city, estimator, inputs }: &Foreseen) -> String {
    let mut lines = Lines::default();
    inputs.iter().for_each(|line| lines.add(line.clone()));
    let i = &plan.facts;
    lines.row("frames", format!("{}, {} pixels", i.frames, short(i.pixels as f64)));
    lines.row("triangles", i.triangles.to_string());
    lines.row("estimator", format!("{estimator}, {:.3} ms a map", 1e3 * i.seconds_per_map));
    if let Some(trial) = i.trial {
        lines.row("casting", format!("{:.3} us a pixel and thread, tried here", 1e6 * trial.seconds_per_pixel));
    }
    lines.row("threads", i.threads.to_string());
    lines.add(format!("{:15}{:>9}{:>8}{:>12}{:>9}", "", "workers", "queue", "memory", "time"));
    for PlannedPhase { name, takes } in &plan.phases {
        let held = i.process + takes.held;
        let peak = Bytes(i.process + takes.peak()).to_string();
        lines.add(format!("{:32}{peak:>12}{:>9}", name.as_str(), time(takes.seconds)));
        if held > 0 && !takes.stages.is_empty() {
            lines.add(format!("  {:30}{:>12}", "held throughout", Bytes(held).to_string()));
        }
        if takes.mapped > 0 {
            lines.add(format!("  {:30}{:>12} on top, the system's to drop", "mapped", Bytes(takes.mapped).to_string()));
        }
        for stage in &takes.stages {
            let memory = if stage.memory > 0 { Bytes(stage.memory).to_string() } else { String::new() };
            let short = match stage.asked {
                asked if asked > stage.workers => format!("  {} of {asked} workers: memory", stage.workers),
                _ => String::new(),
            };
            lines.add(format!("  {:13}{:>9}{:>8}{memory:>12}{short}", stage.name, stage.workers, stage.queue));
        }
    }
    if i.too_large > 0 {
        lines.row(
            "skipped",
            format!(
                "{} of {} frames: reading one takes up to {}, too much for {}",
                i.too_large,
                i.frames,
                Bytes(i.too_large_needs),
                plan.memory
            ),
        );
    }
    if let Some((peak, phase)) = plan.peak() {
        lines.row("memory", format!("{} at most, in {phase}; the limit is {}", Bytes(peak), plan.memory));
    }
    if let Some(city) = city {
        lines.row("city", format!("about {}; {}", Bytes(city.needs), free(city)));
    }
    lines.row("disk", disk(plan.disk(), space));
    lines.row(
        "time",
        match plan.seconds() {
            Some(seconds) => format!("about {}", clock(seconds)),
            None => "unknown: no frame could be tried".to_owned(),
        },
    );
    lines.finish()
}

fn time(seconds: Option<f64>) -> String {
    seconds.map_or_else(|| "unknown".to_owned(), clock)
}

/// The bytes that the run leaves, those still to be written, and the space for them.
fn disk(total: u64, space: &Space) -> String {
    let still =
        if space.needs == total { String::new() } else { format!("{} still to be written; ", Bytes(space.needs)) };
    format!("about {}; {still}{}", Bytes(total), free(space))
}

fn free(space: &Space) -> String {
    let bytes = space.free.map_or("unknown".to_owned(), |free| Bytes(free).to_string());
    format!("{bytes} free for {}", space.folder.display())
}
