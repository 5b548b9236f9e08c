//! The memory of a run, in bytes that are reserved before they are held. Only large holders reserve: the frames under
//! way, the records of a group, a batch of shards; not every buffer. A reservation is given back when it is dropped.
//!
//! [`Budget::reserve`] waits until the bytes are free. Those who wait are served in the order in which they came, so
//! small requests do not starve a large one. A caller that holds bytes while it waits may wait for itself.
//!
//! The budget counts what is reserved. Tests compare it with the memory of the real process.

use std::collections::VecDeque;
use std::sync::{Arc, Mutex};

use crossbeam_channel::{Sender, bounded};

use super::mutex::lock;
use super::stop::StopSignal;
use crate::base::units::Bytes;
use crate::base::{Error, Result};

/// The bytes that one run may hold; clones share them.
#[derive(Debug, Clone)]
pub struct Budget(Arc<Shared>);

#[derive(Debug)]
struct Shared {
    total: u64,
    stop: StopSignal,
    books: Mutex<Books>,
}

#[derive(Debug, Default)]
struct Books {
    used: u64,
    peak: u64,
    waiting: VecDeque<Waiter>,
    next_ticket: u64,
}

#[derive(Debug)]
struct Waiter {
    ticket: u64,
    bytes: u64,
    granted: Sender<()>,
}

/// Bytes held; given back when dropped.
#[derive(Debug)]
#[must_use = "a reservation is given back when it is dropped"]
pub struct Reservation {
    budget: Budget,
    bytes: u64,
}

impl Budget {
    /// A budget of this many bytes. A halt of `stop` ends all waits for bytes.
    pub fn new(total: Bytes, stop: &StopSignal) -> Self {
        Budget(Arc::new(Shared { total: total.0, stop: stop.clone(), books: Mutex::default() }))
    }

    /// All bytes of the budget.
    pub fn total(&self) -> u64 {
        self.0.total
    }

    /// The bytes held now.
    pub fn used(&self) -> u64 {
        lock(&self.0.books).used
    }

    /// The bytes that nobody holds now.
    pub fn left(&self) -> u64 {
        self.0.total - self.used()
    }

    /// The most bytes that were held at once.
    pub fn peak(&self) -> u64 {
        lock(&self.0.books).peak
    }

    /// The error for `who`, which needs `more` bytes than are left.
    pub fn missing(&self, who: &str, more: u64) -> Error {
        let (left, need) = (self.left(), Bytes(self.left().saturating_add(more)));
        let (left, more) = (Bytes(left), Bytes(more));
        Error::invalid(format!(
            "{who} needs {need} of memory, and only {left} is left: raise `[run] memory` by at least {more}"
        ))
    }

    /// Waits for the bytes. The caller must hold none.
    ///
    /// # Errors
    /// More bytes than the whole budget has; `Error::Interrupted` if the run halts first.
    pub fn reserve(&self, who: &str, bytes: u64) -> Result<Reservation> {
        if bytes > self.0.total {
            let (bytes, total) = (Bytes(bytes), Bytes(self.0.total));
            return Err(Error::invalid(format!(
                "{who} needs {bytes} of memory, and the whole run has {total}: raise `[run] memory`"
            )));
        }
        let (ticket, granted) = {
            let mut books = lock(&self.0.books);
            if bytes == 0 || (books.waiting.is_empty() && bytes <= self.0.total - books.used) {
                books.enter(bytes);
                return Ok(Reservation { budget: self.clone(), bytes });
            }
            let (waker, granted) = bounded(1);
            let ticket = books.next_ticket;
            books.next_ticket += 1;
            books.waiting.push_back(Waiter { ticket, bytes, granted: waker });
            (ticket, granted)
        };
        let waited = self.0.stop.recv(&granted);
        let mut books = lock(&self.0.books);
        if let Some(place) = books.waiting.iter().position(|w| w.ticket == ticket) {
            books.waiting.remove(place);
            self.serve(&mut books);
            return Err(Error::Interrupted);
        }
        drop(books);
        // Granted and halted at once: the reservation's drop gives the bytes back.
        let reservation = Reservation { budget: self.clone(), bytes };
        waited.map(|_| reservation)
    }

    /// The number of requests that wait.
    #[cfg(test)]
    pub(super) fn waiting(&self) -> usize {
        lock(&self.0.books).waiting.len()
    }

    fn give_back(&self, bytes: u64) {
        let mut books = lock(&self.0.books);
        books.used -= bytes;
        self.serve(&mut books);
    }

    /// Serves those who wait, in order, as far as the bytes go.
    fn serve(&self, books: &mut Books) {
        while let Some(first) = books.waiting.front()
            && first.bytes <= self.0.total - books.used
            && let Some(first) = books.waiting.pop_front()
        {
            books.enter(first.bytes);
            // The channel has space for this one message. Its receiver takes the bytes even if the run halts.
            first.granted.try_send(()).unwrap_or_default();
        }
    }
}

impl Books {
    fn enter(&mut self, bytes: u64) {
        self.used += bytes;
        self.peak = self.peak.max(self.used);
    }
}

impl Reservation {
    /// The bytes held.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Gives back this many bytes, or all that are held where those are fewer.
    pub fn shrink(&mut self, less: u64) {
        let less = less.min(self.bytes);
        self.bytes -= less;
        self.budget.give_back(less);
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.shrink(self.bytes);
    }
}
