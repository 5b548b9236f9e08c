//! Puts the outputs of n workers back into input order.
//!
//! Each item has a turn, its position in the input. Only the worker whose item has the turn sends; the others may finish
//! items ahead of the turn and park at most one output per item. An item is held from before it is taken until its turn
//! has passed, and at most 2n - 1 are held: one by each worker, and one parked for each worker but one. A second output
//! before the turn waits with its worker. So at most 2n - 1 inputs or first outputs, and n - 1 second ones, are in a map
//! at any time.
//!
//! It cannot deadlock: the channel is first-in first-out, so the item with the turn has been taken, and its worker waits
//! only for the next stage.

use std::collections::BTreeMap;
use std::sync::Mutex;

use crossbeam_channel::{Receiver, Sender, bounded};

use super::channel;
use super::meter::Clock;
use super::mutex::lock;
use super::stop::StopSignal;
use crate::base::{Error, Result};

/// The most items that a map with this many workers has taken and not yet passed on.
pub(super) fn held(workers: usize) -> usize {
    2 * workers - 1
}

/// The order of one map's outputs, shared by its workers.
#[derive(Debug)]
pub(super) struct Order<T> {
    stop: StopSignal,
    turns: Mutex<Turns<T>>,
    /// Only the worker that has the turn uses it, so nobody waits for the lock. `None` once finished.
    sender: Mutex<Option<channel::Sender<T>>>,
    permits: (Sender<()>, Receiver<()>),
}

#[derive(Debug)]
struct Turns<T> {
    /// The item whose turn it is.
    now: u64,
    /// Items ahead of it that are done or whose workers wait.
    ahead: BTreeMap<u64, Ahead<T>>,
    /// Workers that have not ended.
    workers: usize,
}

#[derive(Debug)]
enum Ahead<T> {
    Done(Option<T>),
    Waits(Sender<()>),
}

impl<T> Order<T> {
    /// An order for this many workers (at least 1).
    pub(super) fn new(workers: usize, stop: &StopSignal, sender: channel::Sender<T>) -> Self {
        let permits = bounded(held(workers));
        // The channel has space for exactly these.
        (0..held(workers)).for_each(|_| permits.0.try_send(()).unwrap_or_default());
        Order {
            stop: stop.clone(),
            turns: Mutex::new(Turns { now: 0, ahead: BTreeMap::new(), workers }),
            sender: Mutex::new(Some(sender)),
            permits,
        }
    }

    /// Waits until the worker may take one more item from the input.
    pub(super) fn permit(&self, clock: &mut Clock<'_>) -> Result<()> {
        clock.worked();
        let got = self.stop.recv(&self.permits.1);
        clock.waited_for_output();
        got?.ok_or(Error::Interrupted)
    }

    /// The place of the item at `position` in the order.
    pub(super) fn place(&self, position: u64) -> Place<'_, T> {
        Place { order: self, position, parked: None }
    }

    /// A worker has seen the end of the input. The last one tells the next stage.
    pub(super) fn leave(&self) {
        let mut turns = lock(&self.turns);
        turns.workers -= 1;
        if turns.workers == 0
            && let Some(sender) = lock(&self.sender).take()
        {
            sender.finish();
        }
    }

    fn send(&self, item: T, clock: &mut Clock<'_>) -> Result<()> {
        lock(&self.sender).as_mut().ok_or(Error::Interrupted)?.send(item, clock)
    }

    /// Passes the turn on, sending what was parked, up to the first item that is still being worked on.
    fn pass(&self, clock: &mut Clock<'_>) -> Result<()> {
        loop {
            let next = {
                let mut turns = lock(&self.turns);
                turns.now += 1;
                let now = turns.now;
                turns.ahead.remove(&now)
            };
            // One of the permits that were taken, so the channel has space for it.
            self.permits.0.try_send(()).unwrap_or_default();
            match next {
                Some(Ahead::Done(Some(item))) => self.send(item, clock)?,
                Some(Ahead::Done(None)) => {}
                Some(Ahead::Waits(waker)) => return self.stop.send(&waker, ()),
                None => return Ok(()),
            }
        }
    }
}

/// One item's place in the order.
#[derive(Debug)]
pub(super) struct Place<'a, T> {
    order: &'a Order<T>,
    position: u64,
    parked: Option<T>,
}

impl<T> Place<'_, T> {
    /// Sends an output of this item, or parks it when it is the first and the turn has not come.
    pub(super) fn send(&mut self, item: T, clock: &mut Clock<'_>) -> Result<()> {
        if self.parked.is_none() && lock(&self.order.turns).now != self.position {
            self.parked = Some(item);
            return Ok(());
        }
        if self.parked.is_some() {
            self.wait_for_turn(clock)?;
            self.unpark(clock)?;
        }
        self.order.send(item, clock)
    }

    /// Ends the item: passes the turn on, or leaves the parked output to the worker that has the turn.
    pub(super) fn finish(mut self, clock: &mut Clock<'_>) -> Result<()> {
        {
            let mut turns = lock(&self.order.turns);
            if turns.now != self.position {
                turns.ahead.insert(self.position, Ahead::Done(self.parked.take()));
                return Ok(());
            }
        }
        self.unpark(clock)?;
        self.order.pass(clock)
    }

    fn unpark(&mut self, clock: &mut Clock<'_>) -> Result<()> {
        self.parked.take().map_or(Ok(()), |first| self.order.send(first, clock))
    }

    fn wait_for_turn(&self, clock: &mut Clock<'_>) -> Result<()> {
        let woken = {
            let mut turns = lock(&self.order.turns);
            if turns.now == self.position {
                return Ok(());
            }
            let (waker, woken) = bounded(1);
            turns.ahead.insert(self.position, Ahead::Waits(waker));
            woken
        };
        clock.worked();
        let came = self.order.stop.recv(&woken);
        clock.waited_for_output();
        came?.ok_or(Error::Interrupted)
    }
}
