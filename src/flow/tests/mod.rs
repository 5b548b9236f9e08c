//! Flows of mock stages. Only the watchdog measures time: it turns a hang into a failure.

use std::sync::mpsc;
use std::thread;
use std::time::Duration;

mod backpressure;
mod budget;
mod deadline;
mod mock;
mod order;
mod stopping;

/// Runs `work` on a thread of its own and fails if it does not end.
pub(super) fn within_watchdog<R: Send + 'static>(work: impl FnOnce() -> R + Send + 'static) -> R {
    let (tx, rx) = mpsc::channel();
    let worker = thread::spawn(move || tx.send(work()));
    match rx.recv_timeout(Duration::from_secs(30)) {
        Ok(result) => result,
        Err(mpsc::RecvTimeoutError::Timeout) => panic!("hangs"),
        Err(mpsc::RecvTimeoutError::Disconnected) => match worker.join() {
            Err(payload) => std::panic::resume_unwind(payload),
            Ok(_) => unreachable!("the result was not received"),
        },
    }
}
