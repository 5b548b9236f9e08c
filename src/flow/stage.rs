//! The three kinds of stage, and no more; use the weakest that works. A map is weaker than a fold: it keeps nothing
//! from one item to the next but scratch space, so that any number of workers give the same answer.

use super::meter::{Meter, Skipped};
use crate::base::Result;

/// Produces items, on one thread.
pub trait Source: Send {
    /// What it produces.
    type Out: Send;

    /// How many items it will produce, where it knows; progress is shown against it.
    fn total(&self) -> Option<u64> {
        None
    }

    /// Produces all. When the run drains, `out.send` answers `Error::Interrupted`: pass it on with `?`, or ask
    /// [`Outlet::stopping`] before costly work and return.
    fn run(self, out: &mut Outlet<'_, Self::Out>) -> Result<()>;
}

/// Turns each item into none, one or many, on n workers that share `self`. Outputs leave in input order.
pub trait Map: Send + Sync {
    /// What it takes.
    type In: Send;
    /// What it gives.
    type Out: Send;
    /// What a worker keeps between items to save allocations or set-up. It must not change any output.
    type Scratch;

    /// Makes one worker's scratch, on its thread.
    fn scratch(&self) -> Result<Self::Scratch>;

    /// Treats one item. Outside its turn a worker may run ahead by one output and waits at the second; so a map that
    /// gives many per item is slowed to its own order, and one that gives at most one is not.
    fn apply(&self, scratch: &mut Self::Scratch, item: Self::In, out: &mut Outlet<'_, Self::Out>) -> Result<()>;
}

/// Takes all items in order, on one thread, then gives one result. The only kind of stage that should hold a memory
/// reservation, since it can spill.
pub trait Fold: Send {
    /// What it takes.
    type In: Send;
    /// What comes of it.
    type Out: Send;

    /// Takes one item.
    fn take(&mut self, item: Self::In, meter: &Meter) -> Result<()>;

    /// Commits and concludes. `end` says whether these were all items or the run was asked to stop: then commit what
    /// is whole, and no more.
    fn finish(self, end: End, meter: &Meter) -> Result<Self::Out>;
}

/// How a fold's input ended.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The source produced all that it had.
    Complete,
    /// The source was cut short by a drain; all that it had produced has been folded.
    Drained,
}

/// Where a source or a map puts its outputs.
pub struct Outlet<'a, T> {
    send: &'a mut dyn FnMut(T) -> Result<()>,
    stopping: &'a dyn Fn() -> bool,
    meter: &'a Meter,
}

impl<'a, T> Outlet<'a, T> {
    /// An outlet onto anything; stages are tested with one onto a `Vec`.
    pub fn new(
        meter: &'a Meter,
        stopping: &'a dyn Fn() -> bool,
        send: &'a mut dyn FnMut(T) -> Result<()>,
    ) -> Outlet<'a, T> {
        Outlet { send, stopping, meter }
    }

    /// Passes an item on; waits while the next stage is behind. `Error::Interrupted` when the run stops.
    pub fn send(&mut self, item: T) -> Result<()> {
        (self.send)(item)
    }

    /// Whether to end early. Only a source may heed it: to a map, what is in flight is to be finished.
    pub fn stopping(&self) -> bool {
        (self.stopping)()
    }

    /// Notes an item that cannot be used.
    pub fn skip(&self, skipped: Skipped) {
        self.meter.skip(skipped);
    }

    /// Counts bytes read or written.
    pub fn count_bytes(&self, bytes: u64) {
        self.meter.count_bytes(bytes);
    }
}
