//! `gonio run`: the run on this thread, its progress on another.

use std::io::IsTerminal;
use std::thread;

use crossbeam_channel::bounded;
use serde_json::json;

use super::progress::{Show, Style};
use super::{Ending, err, out, report};
use crate::base::{Error, Result};
use crate::flow::{StopSignal, signal};
use crate::pipeline::{self, Pipeline, Progress};

/// Runs a pipeline and shows how far it is, then what came of it.
///
/// # Errors
/// Whatever breaks the run.
pub fn run(pipeline: &Pipeline, json: bool) -> Result<Ending> {
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
        let ran = pipeline::run(pipeline, &stop, &progress);
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
            Err(why)
        }
        (Err(why), false) => Err(why),
    }
}
