//! Stages made of closures.

use crate::base::Result;
use crate::flow::{End, Fold, Map, Meter, Outlet, Source};

/// A source that calls the closure.
pub(crate) struct From<F>(pub F);

impl<F: FnOnce(&mut Outlet<'_, u64>) -> Result<()> + Send> Source for From<F> {
    type Out = u64;

    fn run(self, out: &mut Outlet<'_, u64>) -> Result<()> {
        (self.0)(out)
    }
}

/// 0, 1, 2 .. for ever.
pub(crate) fn endless() -> From<impl FnOnce(&mut Outlet<'_, u64>) -> Result<()> + Send> {
    From(|out: &mut Outlet<'_, u64>| (0..).try_for_each(|n| out.send(n)))
}

/// 0 up to `n`.
pub(crate) fn count(n: u64) -> From<impl FnOnce(&mut Outlet<'_, u64>) -> Result<()> + Send> {
    From(move |out: &mut Outlet<'_, u64>| (0..n).try_for_each(|n| out.send(n)))
}

/// A map that calls the closure.
pub(crate) struct Each<F>(pub F);

impl<F: Fn(u64, &mut Outlet<'_, u64>) -> Result<()> + Send + Sync> Map for Each<F> {
    type In = u64;
    type Out = u64;
    type Scratch = ();

    fn scratch(&self) -> Result<()> {
        Ok(())
    }

    fn apply(&self, (): &mut (), item: u64, out: &mut Outlet<'_, u64>) -> Result<()> {
        (self.0)(item, out)
    }
}

/// A map that passes all items on.
pub(crate) fn pass() -> Each<impl Fn(u64, &mut Outlet<'_, u64>) -> Result<()> + Send + Sync> {
    Each(|n, out: &mut Outlet<'_, u64>| out.send(n))
}

/// A fold that calls the closure with each item, and gives all items and their end.
pub(crate) struct Gather<F>(pub F, pub Vec<u64>);

impl<F: FnMut(u64) -> Result<()> + Send> Fold for Gather<F> {
    type In = u64;
    type Out = (Vec<u64>, End);

    fn take(&mut self, item: u64, _: &Meter) -> Result<()> {
        (self.0)(item)?;
        self.1.push(item);
        Ok(())
    }

    fn finish(self, end: End, _: &Meter) -> Result<(Vec<u64>, End)> {
        Ok((self.1, end))
    }
}

/// A fold that gives all items.
pub(crate) fn gather() -> Gather<impl FnMut(u64) -> Result<()> + Send> {
    Gather(|_| Ok(()), Vec::new())
}
