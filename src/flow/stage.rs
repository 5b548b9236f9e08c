//! The three kinds of stage; use the weakest that works. A map is weaker than a fold: from one item to the next it keeps
//! nothing but scratch memory, so any number of workers give the same answer.

use super::meter::{Meter, Skipped};
use crate::base::Result;

/// Produces items, on one thread.
pub trait Source: Send {
    /// The items that it produces.
    type Out: Send;

    /// The number of items that it will produce, where it knows; progress is shown against it.
    fn total(&self) -> Option<u64> {
        None
    }

    /// Produces all items. When the run drains, `out.send` returns `Error::Interrupted`: pass it on with `?`, or ask
    /// [`Outlet::stopping`] before costly work and return.
    fn run(self, out: &mut Outlet<'_, Self::Out>) -> Result<()>;
}

/// Turns each item into none, one or many, on n workers that share `self`. Outputs leave in input order.
pub trait Map: Send + Sync {
    /// The items that it takes.
    type In: Send;
    /// The items that it gives.
    type Out: Send;
    /// The memory that a worker keeps between items to save allocations or set-up. It must not change any output.
    type Scratch;

    /// Makes one worker's scratch, on its thread.
    fn scratch(&self) -> Result<Self::Scratch>;

    /// Processes one item. A worker before its turn may run ahead by one output and waits with the second; so a map that
    /// gives many outputs per item waits for its own order, and one that gives at most one does not.
    fn apply(&self, scratch: &mut Self::Scratch, item: Self::In, out: &mut Outlet<'_, Self::Out>) -> Result<()>;
}

/// Takes all items in order, on one thread, then gives one result. Only a fold should hold a reservation of memory for as
/// long as the flow runs: it alone can spill.
pub trait Fold: Send {
    /// The items that it takes.
    type In: Send;
    /// The result.
    type Out: Send;

    /// Takes one item.
    fn take(&mut self, item: Self::In, meter: &Meter) -> Result<()>;

    /// Commits and gives the result. `end` says whether all items came or the run was asked to stop: then commit only
    /// units that are whole.
    fn finish(self, end: End, meter: &Meter) -> Result<Self::Out>;
}

/// The end of a fold's input.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum End {
    /// The source produced all its items.
    Complete,
    /// A drain cut the source short; all items that it had produced have been folded.
    Drained,
}

/// The place where a source or a map puts its outputs.
pub struct Outlet<'a, T> {
    send: &'a mut dyn FnMut(T) -> Result<()>,
    stopping: &'a dyn Fn() -> bool,
    meter: &'a Meter,
}

impl<'a, T> Outlet<'a, T> {
    /// An outlet onto any function; tests of stages use one onto a `Vec`.
    pub fn new(
        meter: &'a Meter,
        stopping: &'a dyn Fn() -> bool,
        send: &'a mut dyn FnMut(T) -> Result<()>,
    ) -> Outlet<'a, T> {
        Outlet { send, stopping, meter }
    }

    /// Passes an item on, and waits while the next queue is full. `Error::Interrupted` when the run stops.
    pub fn send(&mut self, item: T) -> Result<()> {
        (self.send)(item)
    }

    /// Whether to end early. Only a source may ask: a map finishes the items in flight.
    pub fn stopping(&self) -> bool {
        (self.stopping)()
    }

    /// Notes a skipped item.
    pub fn skip(&self, skipped: Skipped) {
        self.meter.skip(skipped);
    }

    /// Counts bytes read or written.
    pub fn count_bytes(&self, bytes: u64) {
        self.meter.count_bytes(bytes);
    }
}
