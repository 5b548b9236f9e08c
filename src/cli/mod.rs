//! The command line: the only code that prints.
//!
//! What was typed ([`args`]) is one type, what it means another ([`Pipeline`](crate::pipeline::Pipeline)). Results go to
//! standard output, everything else to standard error. A closed pipe ends no run: what cannot be shown is dropped.

pub mod args;
mod eval;
mod explain;
mod plan;
mod progress;
mod render;
mod report;
mod run;
mod synth;

use std::ffi::OsString;
use std::io::Write;
use std::process::ExitCode;

use clap::Parser;

use crate::base::{Error, Result};
use crate::pipeline::problem::Problems;
use crate::pipeline::{self, Pipeline};
use args::{Args, Command, PipelineArgs};
use eval::Eval;

/// How a command ended; the number is its exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// All done.
    Done = 0,
    /// Something broke.
    Broken = 1,
    /// The command line or the pipeline file is wrong.
    Misused = 2,
    /// Done, but items were skipped.
    Skipped = 3,
    /// Stopped by a signal; the same command goes on from there.
    Interrupted = 130,
}

impl From<Ending> for ExitCode {
    fn from(ending: Ending) -> ExitCode {
        ExitCode::from(ending as u8)
    }
}

/// Why a command did not do what it was asked.
#[derive(Debug)]
enum Failure {
    /// The pipeline file has problems.
    Problems(Problems),
    /// Something broke.
    Error(Error),
}

impl From<Problems> for Failure {
    fn from(problems: Problems) -> Self {
        Failure::Problems(problems)
    }
}

impl From<Error> for Failure {
    fn from(error: Error) -> Self {
        Failure::Error(error)
    }
}

/// Runs the command that these arguments (the program's name first) ask for.
pub fn main(args: impl IntoIterator<Item = OsString>) -> Ending {
    let args = match Args::try_parse_from(args) {
        Ok(args) => args,
        Err(asked) => {
            // Help and version come this way too. What cannot be shown is dropped.
            asked.print().unwrap_or_default();
            return if asked.use_stderr() { Ending::Misused } else { Ending::Done };
        }
    };
    match command(args.command) {
        Ok(ending) => ending,
        Err(Failure::Problems(problems)) => {
            let count = problems.list.len();
            err(&format!("{problems}\n{count} problem{}", if count == 1 { "" } else { "s" }));
            Ending::Misused
        }
        Err(Failure::Error(error)) => {
            err(&format!("gonio: {error}"));
            if error.is_interrupt() { Ending::Interrupted } else { Ending::Broken }
        }
    }
}

fn command(command: Command) -> Result<Ending, Failure> {
    match command {
        Command::Run { pipeline, json } => Ok(run::run(&load(&pipeline)?, json)?),
        Command::Check { pipeline } => {
            load(&pipeline)?;
            out(&format!("{}: no problems", pipeline.file.display()));
            Ok(Ending::Done)
        }
        Command::Plan { pipeline } => {
            let foreseen = pipeline::plan(&load(&pipeline)?)?;
            out(&plan::table(&foreseen));
            foreseen.works()?;
            Ok(Ending::Done)
        }
        Command::Explain { pipeline } => {
            out(&explain::table(&pipeline::explain(&load(&pipeline)?)?));
            Ok(Ending::Done)
        }
        Command::Buffers { pipeline, frame, out } => {
            pipeline::buffers(&load(&pipeline)?, &frame, &out)?;
            Ok(Ending::Done)
        }
        Command::Maps { pipeline, triangles, out } => {
            pipeline::maps(&load(&pipeline)?, &triangles, &out)?;
            Ok(Ending::Done)
        }
        Command::Synth(what) => Ok(synth::synth(what)?),
        Command::Render { pipeline, options } => {
            render::render(&load(&pipeline)?, &options)?;
            Ok(Ending::Done)
        }
        Command::Eval(what) => {
            let (text, ending) = match what {
                Eval::Images(options) => eval::images(&options)?,
                Eval::Materials(options) => (eval::materials(&options)?, Ending::Done),
                Eval::Scene { pipeline, options } => (eval::scene(&load(&pipeline)?, &options)?, Ending::Done),
            };
            out(&text);
            Ok(ending)
        }
        Command::Export { pipeline } => {
            let written = pipeline::export(&load(&pipeline)?)?;
            written.iter().for_each(|path| out(&path.display().to_string()));
            Ok(Ending::Done)
        }
    }
}

fn load(args: &PipelineArgs) -> Result<Pipeline, Problems> {
    pipeline::check::load(&args.file, &args.set)
}

/// Shows lines on standard output.
fn out(text: &str) {
    writeln!(std::io::stdout().lock(), "{text}").unwrap_or_default();
}

/// Shows lines on standard error.
fn err(text: &str) {
    writeln!(std::io::stderr().lock(), "{text}").unwrap_or_default();
}
