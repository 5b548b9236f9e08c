//! SIGINT and SIGTERM: the first drains the run, the second ends the process at once with exit code 130. Committed files
//! stay; the others are swept when the run is opened again.

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

/// Lets SIGINT and SIGTERM stop the run.
pub fn listen(stop: &StopSignal) -> Result<Listening> {
    let mut listening = Listening(Vec::new());
    for signal in [SIGINT, SIGTERM] {
        // IMPORTANT: handlers run in this order; the first signal must find the flag unset.
        let condition = stop.drain_flag();
        for registered in [
            flag::register_conditional_shutdown(signal, INTERRUPTED, condition),
            flag::register(signal, stop.drain_flag()),
        ] {
            let id = registered.map_err(|why| Error::invalid(format!("cannot listen for signal {signal}: {why}")))?;
            listening.0.push(id);
        }
    }
    Ok(listening)
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
        low_level::raise(SIGTERM).unwrap();
        assert!(stop.draining() && !stop.halted());
        println!("draining");
        low_level::raise(SIGINT).unwrap();
        unreachable!("the second signal ends the process");
    }

    #[test]
    fn the_first_signal_drains_and_the_second_exits() {
        let child = ["flow::signal::tests::raise_twice", "--exact", "--ignored", "--nocapture"];
        let done = Command::new(std::env::current_exe().unwrap()).args(child).output().unwrap();
        assert_eq!(done.status.code(), Some(130), "{done:?}");
        assert!(String::from_utf8_lossy(&done.stdout).contains("draining"), "{done:?}");
    }
}
