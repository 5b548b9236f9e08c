//! From what was typed to an exit code.

use std::ffi::OsString;

use clap::Parser;

use super::args::Args;
use super::ending::{Ending, Failure};
use super::print::err;

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
    match args.command.run() {
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
