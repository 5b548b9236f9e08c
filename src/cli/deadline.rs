//! Work that signals stop, within a deadline.

use std::convert::Infallible;
use std::thread;
use std::time::Duration;

use crossbeam_channel::bounded;

use super::print::err;
use super::streams::last_words;
use crate::base::Result;
use crate::flow::deadline::{Came, watch};
use crate::flow::{StopSignal, signal, spawn};

/// Does work that signals stop. Where it does not end within the grace, nor when it is halted then, the process ends.
///
/// # Errors
/// Signals that cannot be listened for.
pub(super) fn with_deadline<R>(stop: &StopSignal, grace: Duration, work: impl FnOnce() -> R) -> Result<R> {
    let _listening = signal::listen(stop)?;
    Ok(thread::scope(|scope| {
        let (over, watched) = bounded::<Infallible>(0);
        let watching = move || {
            if watch(stop, grace, &watched) == Came::ToNone {
                last_words(
                    b"gonio: interrupted; what was in flight did not end in time; the same command goes on from here\n",
                );
                signal::end_process();
            }
        };
        if let Err(why) = spawn::start(scope, "deadline", true, watching) {
            err(&format!("gonio: no thread is granted that keeps the deadline of a stop: {why}"));
        }
        let done = work();
        drop(over);
        done
    }))
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;

    /// In a process of its own, which ends.
    #[test]
    #[ignore = "run by a_thread_that_never_returns_ends_with_130_and_a_word"]
    fn never_return() {
        let stop = StopSignal::new();
        with_deadline(&stop, Duration::ZERO, || {
            stop.drain();
            thread::sleep(Duration::from_secs(600));
        })
        .unwrap();
    }

    #[test]
    fn a_thread_that_never_returns_ends_with_130_and_a_word() {
        let child = ["cli::deadline::tests::never_return", "--exact", "--ignored", "--nocapture"];
        let done = std::process::Command::new(std::env::current_exe().unwrap()).args(child).output().unwrap();
        assert_eq!(done.status.code(), Some(130), "{done:?}");
        assert!(String::from_utf8_lossy(&done.stderr).contains("gonio: interrupted; "), "{done:?}");
    }
}
