//! The stop of a run before its end: the shared signal, the first cause, and the bomb in every thread.

use std::any::Any;
use std::sync::atomic::{AtomicBool, Ordering};
use std::sync::{Arc, Mutex};

use crossbeam_channel::{Receiver, Sender, select_biased};

use super::mutex::lock;
use super::wake::Wake;
use crate::base::{Error, Result, guard};

/// Stops a run in one of two ways; clones share it. The whole run has one, and a halt cannot be undone.
///
/// Drain asks sources to end early, and the items in flight are finished. Halt ends every wait at once: that of one try of the
/// run ([`halt`](StopSignal::halt)), or that of all of them ([`give_up`](StopSignal::give_up)).
#[derive(Debug, Clone)]
pub struct StopSignal(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    /// In an `Arc` of its own: a signal handler may only set a flag.
    draining: Arc<AtomicBool>,
    given_up: Arc<Wake>,
    halted: Wake,
    cause: Mutex<Option<Error>>,
}

impl Default for StopSignal {
    fn default() -> Self {
        StopSignal::with(Arc::default(), Arc::default())
    }
}

impl StopSignal {
    /// A signal that nobody has given yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// A signal for another try: not halted, drained when this one is, and given up when this one is.
    pub fn again(&self) -> StopSignal {
        StopSignal::with(self.drain_flag(), Arc::clone(&self.0.given_up))
    }

    fn with(draining: Arc<AtomicBool>, given_up: Arc<Wake>) -> StopSignal {
        StopSignal(Arc::new(Shared { draining, given_up, halted: Wake::default(), cause: Mutex::new(None) }))
    }

    /// Asks sources to end; the items in flight are finished and committed.
    pub fn drain(&self) {
        self.0.draining.store(true, Ordering::SeqCst);
    }

    /// Whether sources should end: the run drains or has halted.
    pub fn draining(&self) -> bool {
        self.0.draining.load(Ordering::SeqCst) || self.halted()
    }

    /// Stops all stages at once. The first error that is not itself the consequence of a stop
    /// ([`Error::is_interrupt`]) is kept as the cause.
    pub fn halt(&self, why: Error) {
        if !why.is_interrupt() {
            lock(&self.0.cause).get_or_insert(why);
        }
        self.0.halted.happen();
    }

    /// Stops all stages of this try and of all others at once, without a cause: the run is interrupted.
    pub fn give_up(&self) {
        self.0.given_up.happen();
    }

    /// Whether all stages are to stop at once.
    pub fn halted(&self) -> bool {
        self.0.halted.happened() || self.0.given_up.happened()
    }

    /// The flag that a signal handler sets to drain.
    pub(super) fn drain_flag(&self) -> Arc<AtomicBool> {
        Arc::clone(&self.0.draining)
    }

    /// Takes out the first cause, if there was one.
    pub(super) fn take_cause(&self) -> Option<Error> {
        lock(&self.0.cause).take()
    }

    /// Waits for a message: `None` when the channel has closed, an error when the run halts first.
    pub(super) fn recv<T>(&self, from: &Receiver<T>) -> Result<Option<T>> {
        select_biased! {
            recv(self.0.halted.woken()) -> _ => Err(Error::Interrupted),
            recv(self.0.given_up.woken()) -> _ => Err(Error::Interrupted),
            recv(from) -> got => Ok(got.ok()),
        }
    }

    /// Waits for space and sends: an error when the channel has closed or the run halts first.
    pub(super) fn send<T>(&self, to: &Sender<T>, item: T) -> Result<()> {
        select_biased! {
            recv(self.0.halted.woken()) -> _ => Err(Error::Interrupted),
            recv(self.0.given_up.woken()) -> _ => Err(Error::Interrupted),
            send(to, item) -> sent => sent.map_err(|_| Error::Interrupted),
        }
    }
}

/// Halts the run unless defused: every thread carries one, so no thread dies unnoticed.
#[derive(Debug)]
#[must_use]
pub(super) struct Bomb {
    stop: StopSignal,
    stage: String,
    armed: bool,
}

impl Bomb {
    /// A bomb for one thread of a stage.
    pub(super) fn arm(stop: &StopSignal, stage: &str) -> Self {
        Bomb { stop: stop.clone(), stage: stage.to_owned(), armed: true }
    }

    /// The thread ended well.
    pub(super) fn defuse(mut self) {
        self.armed = false;
    }

    /// The thread ended with an error.
    pub(super) fn blow(mut self, why: Error) {
        self.armed = false;
        self.stop.halt(why);
    }

    /// The thread panicked.
    pub(super) fn blow_panic(self, payload: &(dyn Any + Send)) {
        let why = Error::Panic { stage: self.stage.clone(), message: guard::words(payload).to_owned() };
        self.blow(why);
    }
}

impl Drop for Bomb {
    fn drop(&mut self) {
        if self.armed {
            self.stop.halt(Error::Panic { stage: self.stage.clone(), message: "its thread died".to_owned() });
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_first_cause_is_kept_and_consequences_are_not() {
        let stop = StopSignal::new();
        assert!(!stop.draining());
        stop.halt(Error::Interrupted);
        stop.halt(Error::Interrupted.doing("passing on"));
        assert!(stop.halted() && stop.draining());
        stop.halt(Error::invalid("first"));
        stop.halt(Error::invalid("second"));
        assert_eq!(stop.take_cause().map(|e| e.to_string()).as_deref(), Some("first"));
        assert!(stop.take_cause().is_none());
    }

    #[test]
    fn another_try_is_not_halted_but_still_drained_and_given_up() {
        let stop = StopSignal::new();
        stop.halt(Error::invalid("first"));
        let again = stop.again();
        assert!(!again.halted() && !again.draining() && again.take_cause().is_none());
        stop.drain();
        assert!(again.draining() && !again.halted());
        let (_tx, rx) = crossbeam_channel::bounded::<u8>(0);
        stop.give_up();
        assert!(again.halted() && again.recv(&rx).is_err_and(|e| e.is_interrupt()) && again.take_cause().is_none());
    }

    #[test]
    fn a_bomb_goes_off_unless_defused() {
        let stop = StopSignal::new();
        Bomb::arm(&stop, "a").defuse();
        assert!(!stop.halted());
        let inner = stop.clone();
        let died = std::thread::spawn(move || {
            let _bomb = Bomb::arm(&inner, "b");
            panic!("on purpose");
        });
        assert!(died.join().is_err());
        assert!(matches!(stop.take_cause(), Some(Error::Panic { stage, .. }) if stage == "b"));
    }

    #[test]
    fn a_halt_wakes_those_who_wait() {
        crate::flow::tests::within_watchdog(|| {
            let stop = StopSignal::new();
            let (_tx, rx) = crossbeam_channel::bounded::<u8>(0);
            let inner = stop.clone();
            let waiting = std::thread::spawn(move || inner.recv(&rx).is_err_and(|e| e.is_interrupt()));
            stop.halt(Error::invalid("enough"));
            assert!(waiting.join().unwrap());
        });
    }
}
