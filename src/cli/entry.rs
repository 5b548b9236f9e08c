//! From what was typed to an exit code.

use std::ffi::OsString;
use std::panic::{AssertUnwindSafe, catch_unwind};

use clap::Parser;

use super::args::Args;
use super::ending::{Answer, Ending, Failure};
use super::print::err;
use super::streams::write_out;

/// Runs the command that these arguments (the program's name first) ask for.
pub fn main(args: impl IntoIterator<Item = OsString>) -> Ending {
    // A panic has been told of by then.
    catch_unwind(AssertUnwindSafe(|| ending(answer(args)))).unwrap_or(Ending::Broken)
}

fn answer(args: impl IntoIterator<Item = OsString>) -> Answer {
    match Args::try_parse_from(args) {
        Ok(args) => args.command.run(),
        Err(wrong) if wrong.use_stderr() => {
            wrong.print().unwrap_or_default();
            Ok(Ending::Misused)
        }
        // Help and version.
        Err(asked) => {
            write_out(|_| asked.print())?;
            Ok(Ending::Done)
        }
    }
}

/// Tells of what went wrong.
fn ending(answer: Answer) -> Ending {
    match answer {
        Ok(ending) => ending,
        Err(Failure::Problems(problems)) => {
            let count = problems.list.len() + problems.more;
            err(&format!("{problems}\n{count} problem{}", if count == 1 { "" } else { "s" }));
            Ending::Misused
        }
        Err(Failure::Error(error)) => {
            err(&format!("gonio: {error}"));
            if error.is_interrupt() { Ending::Interrupted } else { Ending::Broken }
        }
    }
}
