//! `gonio run`, and what runs as it does: the work on this thread, its progress on another, the deadline of a stop on a third.

use std::io::IsTerminal;
use std::sync::{Mutex, PoisonError};
use std::thread;

use crossbeam_channel::bounded;
use serde_json::json;

use super::deadline::with_deadline;
use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use super::print::{err, out};
use super::progress::{Show, Style};
use super::report;
use crate::base::Result;
use crate::flow::{StopSignal, spawn};
use crate::phases::{Progress, Report};
use crate::pipeline::Pipeline;
use crate::run::run as run_pipeline;

/// Options of `run`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// Write events to standard output, one JSON object a line, and nothing else
    #[arg(long)]
    json: bool,
}

/// Runs a pipeline and shows how far it is, then what came of it.
pub(super) fn run(args: &Args) -> Answer {
    let pipeline = args.pipeline.load()?;
    shown(&pipeline, args.json, &run_pipeline, &|report| report::table(report, &pipeline.run.work))
}

/// Does work on a pipeline and shows how far it is, then what came of it.
pub(super) fn shown(
    pipeline: &Pipeline,
    json: bool,
    work: &(dyn Fn(&Pipeline, &StopSignal, &Progress) -> Result<Report> + Sync),
    table: &dyn Fn(&Report) -> String,
) -> Answer {
    let (stop, progress) = (StopSignal::new(), Progress::new());
    let style = match (json, std::io::stderr().is_terminal()) {
        (true, _) => Style::Json,
        (false, true) => Style::Terminal,
        (false, false) => Style::Plain,
    };
    let shown = Mutex::new(Ok(()));
    let ran = with_deadline(&stop, pipeline.run.grace(), || {
        thread::scope(|scope| {
            let (done, running) = bounded::<()>(0);
            let (told, stopping, shown) = (&progress, &stop, &shown);
            let show = move || {
                let all = Show::new(style).until(&running, told, stopping);
                *shown.lock().unwrap_or_else(PoisonError::into_inner) = all;
            };
            if let Err(why) = spawn::start(scope, "progress", true, show) {
                err(&format!("gonio: no thread is granted that shows progress: {why}"));
            }
            let ran = work(pipeline, &stop, &progress);
            drop(done);
            ran
        })
    })?;
    let shown = shown.into_inner().unwrap_or_else(PoisonError::into_inner);
    match ran {
        Ok(report) => {
            let event = || json!({ "event": "done", "report": report }).to_string();
            let told = shown.and_then(|()| out(&if json { event() } else { table(&report) }));
            told.map_err(|why| {
                why.doing(format!("the run is done, and {} has its results", pipeline.run.work.display()))
            })?;
            Ok(if report.skipped.is_empty() { Ending::Done } else { Ending::Skipped })
        }
        Err(why) => {
            if json {
                let event = json!({ "event": "failed", "interrupted": why.is_interrupt(), "why": why.to_string() });
                // What broke the run counts for more than that it cannot be told here.
                shown.and_then(|()| out(&event.to_string())).unwrap_or_default();
            }
            Err(why.into())
        }
    }
}
