//! The signals that stop a run: SIGINT, SIGTERM, and SIGHUP unless it is ignored, as under nohup. The first drains the run, the
//! second ends the process at once with exit code 130. SIGXCPU, which the system repeats once a limit on processor time is
//! passed, drains. Committed files stay; the others are swept when the run is opened again.

use signal_hook::consts::{SIGINT, SIGTERM};
use signal_hook::{SigId, flag, low_level};

use super::stop::StopSignal;
use crate::base::{Error, Result};

/// The exit code that a shell expects of an interrupted command.
const INTERRUPTED: i32 = 130;

/// Signals reach the stop signal as long as this lives.
#[derive(Debug)]
#[must_use = "signals are heard only while this lives"]
pub struct Listening(Vec<SigId>);

/// Lets signals stop the run.
pub fn listen(stop: &StopSignal) -> Result<Listening> {
    let mut listening = Listening(Vec::new());
    for signal in stopping() {
        // IMPORTANT: handlers run in this order; the first signal must find the flag unset.
        listening.add(signal, flag::register_conditional_shutdown(signal, INTERRUPTED, stop.drain_flag()))?;
        listening.add(signal, flag::register(signal, stop.drain_flag()))?;
    }
    #[cfg(unix)]
    listening.add(libc::SIGXCPU, flag::register(libc::SIGXCPU, stop.drain_flag()))?;
    Ok(listening)
}

impl Listening {
    fn add(&mut self, signal: i32, registered: std::io::Result<SigId>) -> Result<()> {
        let id = registered.map_err(|why| Error::invalid(format!("cannot listen for signal {signal}: {why}")))?;
        self.0.push(id);
        Ok(())
    }
}

/// The signals of which a second one ends the process.
fn stopping() -> Vec<i32> {
    #[cfg(unix)]
    if !is_ignored(libc::SIGHUP) {
        return vec![SIGINT, SIGTERM, libc::SIGHUP];
    }
    vec![SIGINT, SIGTERM]
}

/// Whether the process ignores a signal, as it was told to by the one that started it.
#[cfg(unix)]
fn is_ignored(signal: i32) -> bool {
    // SAFETY: all bytes zero are a `sigaction`, and the call only fills it in.
    unsafe {
        let mut now: libc::sigaction = std::mem::zeroed();
        libc::sigaction(signal, std::ptr::null(), &mut now) == 0 && now.sa_sigaction == libc::SIG_IGN
    }
}

/// Ignores SIGXFSZ: a write beyond the limit on the size of a file (`ulimit -f`) is then an error of that write.
pub(crate) fn ignore_limits_of_file_size() {
    #[cfg(unix)]
    // SAFETY: to ignore a signal runs no code of ours.
    unsafe {
        libc::signal(libc::SIGXFSZ, libc::SIG_IGN);
    }
}

/// Ends the process at once, as the second signal does, whatever its threads do.
pub(crate) fn end_process() -> ! {
    low_level::exit(INTERRUPTED)
}

impl Drop for Listening {
    fn drop(&mut self) {
        self.0.iter().for_each(|&id| {
            low_level::unregister(id);
        });
    }
}

#[cfg(test)]
mod tests {
    use std::process::Command;

    use super::*;

    /// In a process of its own, since the second signal ends it and tests share theirs.
    #[test]
    #[ignore = "run by the_first_signal_drains_and_the_second_exits"]
    fn raise_twice() {
        let stop = StopSignal::new();
        let _listening = listen(&stop).unwrap();
        let first = std::env::var("GONIO_TEST_SIGNAL").unwrap().parse().unwrap();
        low_level::raise(first).unwrap();
        assert!(stop.draining() && !stop.halted());
        println!("draining");
        low_level::raise(SIGINT).unwrap();
        unreachable!("the second signal ends the process");
    }

    #[test]
    fn the_first_signal_drains_and_the_second_exits() {
        let child = ["flow::signal::tests::raise_twice", "--exact", "--ignored", "--nocapture"];
        // Without SIGHUP where the tests are told to ignore it, as under nohup.
        #[cfg(unix)]
        let firsts = [stopping(), vec![libc::SIGXCPU]].concat();
        #[cfg(not(unix))]
        let firsts = stopping();
        for first in firsts {
            let mut command = Command::new(std::env::current_exe().unwrap());
            let done = command.args(child).env("GONIO_TEST_SIGNAL", first.to_string()).output().unwrap();
            assert_eq!(done.status.code(), Some(130), "{done:?}");
            assert!(String::from_utf8_lossy(&done.stdout).contains("draining"), "{done:?}");
        }
    }
}
