//! The dataflow engine: one source, any number of maps, one fold, joined by bounded channels on named threads. It
//! knows nothing of scenes and prints nothing.
//!
//! ```text
//! Source ──queue──▶ Map (n workers) ──queue──▶ ... ──queue──▶ Fold ──▶ result
//! ```
//!
//! Invariants:
//! - **Order.** A map's outputs leave in the order of its inputs, however many workers it has. So the fold gets one
//!   sequence, and the same sequence every time.
//! - **Bounds.** A queue holds at most its bound; a map with n workers holds at most 2n - 1 items that it has taken and
//!   not yet passed on (`order`). No stage sends upstream. One [`Budget`] bounds the bytes of the run.
//! - **Ends are announced.** A producer that is done says so; a channel that merely closes means that its producer died.
//!   No fold finishes on half an input by mistake.
//! - **Two ways to stop.** *Drain* (a first SIGINT): sources end early, the items in flight are folded, the fold finishes
//!   with [`End::Drained`], and then the run returns `Error::Interrupted`. *Halt* (an error, a panic, a drain that took too
//!   long): every wait ends at once, no fold finishes, all threads join, and the run returns the first cause.
//! - **Few threads will do.** A map goes on with the workers that the system grants, if there is one; a stage without a thread
//!   halts the run.
//! - **Consequences are not causes.** A stage gets `Error::Interrupted` from a closed or halted neighbour, and passes it
//!   on with `?`. Such an error stops the run but is never reported in place of the cause.
//! - **A bad item is not an error.** It is skipped, with the reason and a command that replays it ([`Skipped`]).

pub mod budget;
mod channel;
pub(crate) mod deadline;
pub mod meter;
mod mutex;
mod order;
pub mod pool;
pub mod run;
pub mod signal;
pub(crate) mod spawn;
pub mod stage;
pub mod stop;
mod wake;

pub use budget::{Budget, Reservation};
pub use meter::{Meter, Reading, Skipped};
pub use run::{Flow, Ready};
pub use stage::{End, Fold, Map, Outlet, Source};
pub use stop::StopSignal;

#[cfg(test)]
mod tests;
