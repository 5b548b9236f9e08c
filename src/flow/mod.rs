//! The dataflow engine: one source, any number of maps, one fold, joined by bounded channels on named threads. It
//! knows nothing of scenes and prints nothing.
//!
//! ```text
//! Source ──queue──▶ Map (n workers) ──queue──▶ ... ──queue──▶ Fold ──▶ result
//! ```
//!
//! Invariants:
//! - **Order.** A map's outputs leave in the order of its inputs, however many workers it has. So the fold sees one
//!   sequence, and the same sequence every time.
//! - **Bounds.** A queue holds at most its bound; a map with n workers holds at most 2n - 1 items that it has taken and
//!   not yet passed on (`order`). Nothing is sent upstream. Bytes are bounded by one [`Budget`] for the run.
//! - **Ends are said.** A producer that is done says so; a channel that merely closes means that its producer died.
//!   No fold ever finishes on half an input by mistake.
//! - **Two ways to stop.** *Drain* (a first SIGINT): sources end early, what is in flight is folded, the fold finishes
//!   with [`End::Drained`], and then the run answers `Error::Interrupted`. *Halt* (an error, a panic): every wait ends
//!   at once, no fold finishes, all threads join, and the run answers the first cause.
//! - **Consequences are no causes.** What a stage gets from a closed or halted neighbour is `Error::Interrupted`; pass
//!   it on with `?`. Such an error stops the run but is never reported in place of the cause.
//! - **A bad item is no error.** It is skipped with words and a command that replays it ([`Skipped`]).

pub mod budget;
mod channel;
pub mod meter;
mod order;
pub mod pool;
pub mod run;
pub mod signal;
pub mod stage;
pub mod stop;

pub use budget::{Budget, Refusal, Reservation};
pub use meter::{Meter, Reading, Skipped};
pub use run::{Flow, Ready};
pub use stage::{End, Fold, Map, Outlet, Source};
pub use stop::StopSignal;

use std::sync::{Mutex, MutexGuard, PoisonError};

/// Locks, also after a panic elsewhere: no lock of this folder is held while a stage's code runs, so what it guards
/// is whole.
fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

#[cfg(test)]
mod tests;
