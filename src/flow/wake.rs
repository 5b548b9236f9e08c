//! Something that happens once and that many waits listen for.

use std::convert::Infallible;
use std::sync::Mutex;
use std::sync::atomic::{AtomicBool, Ordering};

use crossbeam_channel::{Receiver, Sender, bounded};

use super::mutex::lock;

/// Something that happens once.
#[derive(Debug)]
pub(super) struct Wake {
    happened: AtomicBool,
    /// Nothing is ever sent here. Dropping it closes the channel to which every wait listens.
    awake: Mutex<Option<Sender<Infallible>>>,
    woken: Receiver<Infallible>,
}

impl Default for Wake {
    fn default() -> Self {
        let (awake, woken) = bounded(0);
        Wake { happened: AtomicBool::new(false), awake: Mutex::new(Some(awake)), woken }
    }
}

impl Wake {
    /// Makes it happen; wakes all who wait.
    pub(super) fn happen(&self) {
        self.happened.store(true, Ordering::SeqCst);
        lock(&self.awake).take();
    }

    /// Whether it has happened.
    pub(super) fn happened(&self) -> bool {
        self.happened.load(Ordering::SeqCst)
    }

    /// The channel that closes when it happens.
    pub(super) fn woken(&self) -> &Receiver<Infallible> {
        &self.woken
    }
}
