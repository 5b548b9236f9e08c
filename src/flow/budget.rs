//! The bytes of a run. Only large holders register: a fold that gathers, a cache, a batch; not every buffer. Who holds,
//! reserves first, and gives back by dropping. On refusal a holder spills and tries again.
//!
//! - [`Budget::reserve`] waits. Only who holds nothing may call it, or it may wait for itself. Those who wait are
//!   served in the order in which they came, so a large request is not starved by small ones.
//! - [`Budget::try_reserve`] and [`Reservation::grow`] never wait: they refuse, in words. They are refused while others
//!   wait, so that a holder spills and makes room for them.
//! - The budget counts what is said to it. Tests hold it against the memory of the real process.

use std::collections::{BTreeMap, VecDeque};
use std::fmt;
use std::sync::{Arc, Mutex};

use crossbeam_channel::{Sender, bounded};

use super::{StopSignal, lock};
use crate::base::units::Bytes;
use crate::base::{Error, Result};

/// The bytes that one run may hold; cloning shares it.
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
    holders: BTreeMap<String, u64>,
    waiting: VecDeque<Waiter>,
    next_ticket: u64,
}

#[derive(Debug)]
struct Waiter {
    ticket: u64,
    who: String,
    bytes: u64,
    granted: Sender<()>,
}

/// Bytes held; given back when dropped.
#[derive(Debug)]
#[must_use = "a reservation is given back when it is dropped"]
pub struct Reservation {
    budget: Budget,
    who: String,
    bytes: u64,
}

/// Why bytes were not given.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Refusal {
    /// Who asked.
    pub who: String,
    /// For how many bytes more.
    pub asked: u64,
    /// How many bytes it holds already.
    pub held: u64,
    /// How many bytes nobody holds.
    pub left: u64,
    /// How many bytes there are in all.
    pub total: u64,
    /// How many others wait and come first.
    pub waiting: usize,
}

impl fmt::Display for Refusal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Refusal { who, waiting, .. } = self;
        let [asked, held, left, total] = [self.asked, self.held, self.left, self.total].map(Bytes);
        write!(f, "{who} asked for {asked} of memory and holds {held}; of {total} in all, {left} are left")?;
        if *waiting > 0 {
            write!(f, " and {waiting} wait for more")?;
        }
        Ok(())
    }
}

impl From<Refusal> for Error {
    fn from(refusal: Refusal) -> Error {
        Error::invalid(format!("{refusal}: raise `[run] memory`"))
    }
}

impl Budget {
    /// A budget of this many bytes. A halt of `stop` ends all waits for it.
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

    /// What to answer where `who` cannot do with what is left, by so many bytes.
    pub fn missing(&self, who: &str, bytes: u64) -> Error {
        let (left, bytes) = (Bytes(self.left()), Bytes(bytes));
        Error::invalid(format!(
            "{who} cannot do with the {left} of memory that are left: give [run] memory {bytes} more"
        ))
    }

    /// The most bytes that were held at once.
    pub fn peak(&self) -> u64 {
        lock(&self.0.books).peak
    }

    /// Who holds how many bytes now, by name.
    pub fn holders(&self) -> Vec<(String, u64)> {
        lock(&self.0.books).holders.iter().map(|(who, bytes)| (who.clone(), *bytes)).collect()
    }

    /// Waits for the bytes. The caller must hold none.
    ///
    /// # Errors
    /// A request that the whole budget could not meet; `Error::Interrupted` if the run halts first.
    pub fn reserve(&self, who: &str, bytes: u64) -> Result<Reservation> {
        let (ticket, granted) = {
            let mut books = lock(&self.0.books);
            match self.take(&mut books, who, bytes) {
                Ok(()) => return Ok(self.reservation(who, bytes)),
                Err(refusal) if bytes > self.0.total => return Err(refusal.into()),
                Err(_) => {}
            }
            let (waker, granted) = bounded(1);
            let ticket = books.next_ticket;
            books.next_ticket += 1;
            books.waiting.push_back(Waiter { ticket, who: who.to_owned(), bytes, granted: waker });
            (ticket, granted)
        };
        let waited = self.0.stop.recv(&granted);
        // Granted and halted at once: what was granted is given back by the reservation's drop.
        let mut books = lock(&self.0.books);
        if let Some(place) = books.waiting.iter().position(|w| w.ticket == ticket) {
            books.waiting.remove(place);
            self.serve(&mut books);
            return Err(Error::Interrupted);
        }
        drop(books);
        let reservation = self.reservation(who, bytes);
        waited.map(|_| reservation)
    }

    /// The bytes at once, or a refusal.
    pub fn try_reserve(&self, who: &str, bytes: u64) -> Result<Reservation, Refusal> {
        self.take(&mut lock(&self.0.books), who, bytes)?;
        Ok(self.reservation(who, bytes))
    }

    fn reservation(&self, who: &str, bytes: u64) -> Reservation {
        Reservation { budget: self.clone(), who: who.to_owned(), bytes }
    }

    fn take(&self, books: &mut Books, who: &str, bytes: u64) -> Result<(), Refusal> {
        let left = self.0.total - books.used;
        if bytes > 0 && (bytes > left || !books.waiting.is_empty()) {
            let held = books.holders.get(who).copied().unwrap_or(0);
            let (who, waiting) = (who.to_owned(), books.waiting.len());
            return Err(Refusal { who, asked: bytes, held, left, total: self.0.total, waiting });
        }
        books.enter(who, bytes);
        Ok(())
    }

    fn give_back(&self, who: &str, bytes: u64) {
        let mut books = lock(&self.0.books);
        books.used -= bytes;
        if let Some(held) = books.holders.get_mut(who) {
            *held -= bytes;
            if *held == 0 {
                books.holders.remove(who);
            }
        }
        self.serve(&mut books);
    }

    /// Serves those who wait, in order, as far as the bytes go.
    fn serve(&self, books: &mut Books) {
        while let Some(first) = books.waiting.front()
            && first.bytes <= self.0.total - books.used
            && let Some(first) = books.waiting.pop_front()
        {
            books.enter(&first.who, first.bytes);
            // There is room for this one message; whoever waits for it takes the bytes even if the run halts.
            first.granted.try_send(()).unwrap_or_default();
        }
    }
}

impl Books {
    fn enter(&mut self, who: &str, bytes: u64) {
        self.used += bytes;
        self.peak = self.peak.max(self.used);
        if bytes > 0 {
            *self.holders.entry(who.to_owned()).or_default() += bytes;
        }
    }
}

impl Reservation {
    /// The bytes held.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    /// Holds this many bytes more, or is refused and holds what it held.
    pub fn grow(&mut self, more: u64) -> Result<(), Refusal> {
        self.budget.take(&mut lock(&self.budget.0.books), &self.who, more)?;
        self.bytes += more;
        Ok(())
    }

    /// Gives back this many bytes, or all that it holds where that is less.
    pub fn shrink(&mut self, less: u64) {
        let less = less.min(self.bytes);
        self.bytes -= less;
        self.budget.give_back(&self.who, less);
    }
}

impl Drop for Reservation {
    fn drop(&mut self) {
        self.shrink(self.bytes);
    }
}
