//! How a command ends.

use std::process::ExitCode;

use crate::base::Error;
use crate::config::Problems;

/// How a command ended; the number is the exit code.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Ending {
    /// The command did all that it was asked.
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
pub(super) enum Failure {
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

/// What every command answers.
pub(super) type Answer = Result<Ending, Failure>;
