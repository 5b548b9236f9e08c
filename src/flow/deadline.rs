//! The deadline of a stop. A drain that does not end within its grace becomes a halt. A halt that does not end soon either
//! cannot: a thread is stuck, as in reading from a device that does not answer. Then nothing helps but the end of the process,
//! and that is up to the caller. Committed units stay whole however the process ends.

use std::convert::Infallible;
use std::time::Duration;

use crossbeam_channel::{Receiver, RecvTimeoutError};

use super::stop::StopSignal;

/// The grace of a drain where nothing else is asked for.
pub(crate) const GRACE: Duration = Duration::from_secs(30);

/// The time that a halt may take.
pub(super) const HALT: Duration = Duration::from_secs(2);

/// The time between two looks at whether the run drains.
pub(super) const LOOK: Duration = Duration::from_millis(50);

/// What came of work that was told to stop, or was not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Came {
    /// The work ended, by itself or because it was halted.
    ToAnEnd,
    /// The work goes on although it was halted.
    ToNone,
}

/// Waits until work is over, which closes the channel, and halts it where it drains for longer than its grace.
pub(crate) fn watch(stop: &StopSignal, grace: Duration, over: &Receiver<Infallible>) -> Came {
    let is_over_within = |time: Duration| over.recv_timeout(time) != Err(RecvTimeoutError::Timeout);
    while !stop.draining() {
        if is_over_within(LOOK) {
            return Came::ToAnEnd;
        }
    }
    if is_over_within(grace) {
        return Came::ToAnEnd;
    }
    stop.give_up();
    if is_over_within(HALT) { Came::ToAnEnd } else { Came::ToNone }
}
