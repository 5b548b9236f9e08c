//! The photographs of a city that are still to be taken.

use std::cell::Cell;

use crate::base::{Error, Result};
use crate::scene::frame::Frame;

/// The photographs that are still to be taken, one after the other.
pub(super) struct Missing<'a> {
    /// The frames, each with its number among all.
    pub frames: Vec<(usize, &'a Frame)>,
    taken: Cell<usize>,
    tell: &'a dyn Fn(usize),
    stop: &'a dyn Fn() -> bool,
}

impl<'a> Missing<'a> {
    /// These frames of so many. `tell` is told how many of all photographs there are; `stop` is asked before each.
    pub(super) fn new(
        frames: Vec<(usize, &'a Frame)>,
        all: usize,
        tell: &'a dyn Fn(usize),
        stop: &'a dyn Fn() -> bool,
    ) -> Self {
        let there = all - frames.len();
        tell(there);
        Missing { frames, taken: Cell::new(there), tell, stop }
    }

    /// Takes one of them.
    ///
    /// # Errors
    /// `Error::Interrupted` where it is to stop; what `take` answers.
    pub(super) fn take(&self, take: impl FnOnce() -> Result<()>) -> Result<()> {
        if (self.stop)() {
            return Err(Error::Interrupted);
        }
        take()?;
        self.taken.set(self.taken.get() + 1);
        (self.tell)(self.taken.get());
        Ok(())
    }
}
