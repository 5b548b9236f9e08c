//! Bounded channels between two stages. Items carry their position in the sequence, and waits are metered on both sides.
//! [`Sender::finish`] announces the end, so a producer that died is never taken for one that is done.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use super::meter::{Clock, Meter};
use super::stop::StopSignal;
use crate::base::{Error, Result};

/// A channel that holds at most `bound` items, between the stages with these meters.
pub(super) fn bounded<T>(
    bound: usize,
    stop: &StopSignal,
    from: &Arc<Meter>,
    to: &Arc<Meter>,
) -> (Sender<T>, Receiver<T>) {
    let (tx, rx) = crossbeam_channel::bounded(bound);
    let finished = Arc::new(AtomicBool::new(false));
    let sender = Sender {
        tx,
        next: 0,
        finished: Arc::clone(&finished),
        stop: stop.clone(),
        from: Arc::clone(from),
        to: Arc::clone(to),
    };
    (sender, Receiver { rx, finished, stop: stop.clone(), meter: Arc::clone(to) })
}

/// The producing end. It has one owner, so positions have no gaps.
#[derive(Debug)]
pub(super) struct Sender<T> {
    tx: crossbeam_channel::Sender<(u64, T)>,
    next: u64,
    finished: Arc<AtomicBool>,
    stop: StopSignal,
    from: Arc<Meter>,
    to: Arc<Meter>,
}

impl<T> Sender<T> {
    /// Sends an item once the queue has space. `Error::Interrupted` when the run halts or the consumer is gone.
    pub(super) fn send(&mut self, item: T, clock: &mut Clock<'_>) -> Result<()> {
        clock.worked();
        let sent = self.stop.send(&self.tx, (self.next, item));
        clock.waited_for_output();
        sent?;
        self.next += 1;
        self.from.passed();
        self.to.set_queue(self.tx.len());
        Ok(())
    }

    /// Announces that no item follows.
    pub(super) fn finish(self) {
        self.finished.store(true, Ordering::Release);
    }
}

/// The consuming end; the workers of a map share it.
#[derive(Debug)]
pub(super) struct Receiver<T> {
    rx: crossbeam_channel::Receiver<(u64, T)>,
    finished: Arc<AtomicBool>,
    stop: StopSignal,
    meter: Arc<Meter>,
}

impl<T> Clone for Receiver<T> {
    fn clone(&self) -> Self {
        Receiver {
            rx: self.rx.clone(),
            finished: Arc::clone(&self.finished),
            stop: self.stop.clone(),
            meter: Arc::clone(&self.meter),
        }
    }
}

impl<T> Receiver<T> {
    /// The next item and its position; `None` when the producer has finished. `Error::Interrupted` when the run halts
    /// or the producer died.
    pub(super) fn recv(&self, clock: &mut Clock<'_>) -> Result<Option<(u64, T)>> {
        clock.worked();
        let got = self.stop.recv(&self.rx);
        clock.waited_for_input();
        match got? {
            Some(item) => {
                self.meter.took(self.rx.len());
                Ok(Some(item))
            }
            None if self.finished.load(Ordering::Acquire) => Ok(None),
            None => Err(Error::Interrupted),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn only_a_finished_producer_ends_the_input() {
        for finish in [true, false] {
            let meter = Arc::new(Meter::new("m", 1, 2, None));
            let mut clock = Clock::start(&meter);
            let (mut tx, rx) = bounded(2, &StopSignal::new(), &meter, &meter);
            tx.send('a', &mut clock).unwrap();
            assert_eq!(meter.read().queue, 1);
            if finish {
                tx.finish()
            } else {
                drop(tx)
            }
            assert_eq!(rx.recv(&mut clock).unwrap(), Some((0, 'a')));
            assert_eq!(rx.recv(&mut clock).is_ok_and(|end| end.is_none()), finish);
        }
    }

    #[test]
    fn a_gone_consumer_is_a_consequence() {
        let meter = Arc::new(Meter::new("m", 1, 2, None));
        let (mut tx, rx) = bounded(2, &StopSignal::new(), &meter, &meter);
        drop(rx);
        assert!(tx.send(1, &mut Clock::start(&meter)).is_err_and(|e| e.is_interrupt()));
    }
}
