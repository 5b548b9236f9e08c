//! The command as a process of its own, its memory looked at every few milliseconds.

use std::fs;
use std::io::{self, Error};
use std::process::{Command, ExitStatus, Stdio};
use std::thread::sleep;
use std::time::{Duration, Instant};

use gonio::base::memory;

/// How often the memory is looked at.
const EVERY: Duration = Duration::from_millis(5);

/// What a process did.
pub struct Ran {
    command: String,
    status: ExitStatus,
    /// From its start to its end.
    pub wall: Duration,
    /// The most bytes that the system could not have taken back: RssAnon and RssShmem together.
    pub peak: u64,
}

impl Ran {
    /// Itself, if it did all that it was asked.
    pub fn whole(self) -> io::Result<Ran> {
        if self.status.success() { Ok(self) } else { Err(Error::other(format!("{}: {}", self.command, self.status))) }
    }
}

/// Runs `gonio` with these arguments, separated by blanks; kills it after `limit`, if there is one.
pub fn gonio(args: &str, limit: Option<Duration>) -> io::Result<Ran> {
    let mut command = Command::new(env!("CARGO_BIN_EXE_gonio"));
    let started = Instant::now();
    let mut child = command.args(args.split_whitespace()).stdout(Stdio::null()).stderr(Stdio::null()).spawn()?;
    let mut peak = 0;
    let status = loop {
        if let Some(status) = child.try_wait()? {
            break status;
        }
        if limit.is_some_and(|limit| started.elapsed() >= limit) {
            child.kill()?;
            break child.wait()?;
        }
        let status = fs::read_to_string(format!("/proc/{}/status", child.id())).ok();
        peak = peak.max(status.as_deref().and_then(memory::anonymous).unwrap_or(0));
        sleep(EVERY);
    };
    Ok(Ran { command: format!("gonio {args}"), status, wall: started.elapsed(), peak })
}
