//! `gonio run`: the run on this thread, its progress on another.

use std::io::IsTerminal;
use std::thread;

use crossbeam_channel::bounded;
use serde_json::json;

use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use super::print::{err, out};
use super::progress::{Show, Style};
use super::report;
use crate::base::Error;
use crate::flow::{StopSignal, signal};
use crate::phases::Progress;
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
    let (pipeline, json) = (args.pipeline.load()?, args.json);
    let (stop, progress) = (StopSignal::new(), Progress::new());
    let _listening = signal::listen(&stop)?;
    let style = match (json, std::io::stderr().is_terminal()) {
        (true, _) => Style::Json,
        (false, true) => Style::Terminal,
        (false, false) => Style::Plain,
    };
    let ran = thread::scope(|scope| {
        let (done, running) = bounded::<()>(0);
        let (told, stopping) = (&progress, &stop);
        let show = move || Show::new(style).until(&running, told, stopping);
        let shown = thread::Builder::new().name("progress".to_owned()).spawn_scoped(scope, show);
        let shown = shown.map_err(|why| Error::invalid(format!("cannot start a thread: {why}")))?;
        let ran = run_pipeline(&pipeline, &stop, &progress);
        drop(done);
        // A panic there must not take the run's result with it.
        shown.join().unwrap_or_else(|_| err("gonio: the display of progress failed"));
        ran
    });
    match (ran, json) {
        (Ok(report), _) => {
            if json {
                out(&json!({ "event": "done", "report": report }).to_string());
            } else {
                out(&report::table(&report));
            }
            Ok(if report.skipped.is_empty() { Ending::Done } else { Ending::Skipped })
        }
        (Err(why), true) => {
            out(&json!({ "event": "failed", "interrupted": why.is_interrupt(), "why": why.to_string() }).to_string());
            Err(why.into())
        }
        (Err(why), false) => Err(why.into()),
    }
}
