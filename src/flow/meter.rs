//! The counters of a stage, which another thread may read while the run goes on.
//!
//! A thread's time is split without gaps into busy, waiting for input and waiting for output: over a stage the three add
//! up to the lifetimes of all workers. The bottleneck is the stage that is busy while the stages before it wait for
//! output and the stages after it wait for input.

use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use serde::{Deserialize, Serialize};

use super::mutex::lock;

/// An item that could not be used. The run goes on without it, and its exit code says so.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Skipped {
    /// The item's name, as the user knows it: a frame's name.
    pub item: String,
    /// The reason, in words.
    pub why: String,
    /// The command that does this one item again.
    pub replay: String,
}

/// The counters of one stage, which may be read at any time.
#[derive(Debug, Default)]
pub struct Meter {
    name: String,
    workers: AtomicUsize,
    queue_bound: usize,
    total: Option<u64>,
    items_in: AtomicU64,
    items_out: AtomicU64,
    bytes: AtomicU64,
    busy: AtomicU64,
    wait_in: AtomicU64,
    wait_out: AtomicU64,
    queue: AtomicUsize,
    skipped: Mutex<Vec<Skipped>>,
}

/// The counters of one stage at one moment.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub struct Reading {
    /// Items taken from the queue.
    pub items_in: u64,
    /// Items passed on.
    pub items_out: u64,
    /// Bytes that the stage says it has read or written.
    pub bytes: u64,
    /// Thread time spent working, summed over workers.
    pub busy: Duration,
    /// Thread time spent waiting for input, summed over workers.
    pub wait_in: Duration,
    /// Thread time spent waiting for space in the next queue, or for a turn, summed over workers.
    pub wait_out: Duration,
    /// Items waiting in the queue before the stage.
    pub queue: usize,
    /// Items skipped.
    pub skipped: u64,
}

impl Meter {
    /// A meter at zero. `total` is the number of items that the stage will pass on, where it knows.
    pub fn new(name: &str, workers: usize, queue_bound: usize, total: Option<u64>) -> Self {
        Meter { name: name.to_owned(), workers: AtomicUsize::new(workers), queue_bound, total, ..Self::default() }
    }

    /// The stage's name.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// The number of its threads.
    pub fn workers(&self) -> usize {
        self.workers.load(Ordering::Relaxed)
    }

    /// The most items that its queue holds; 0 for a source, which has none.
    pub fn queue_bound(&self) -> usize {
        self.queue_bound
    }

    /// The number of items that the stage will pass on, where it knows.
    pub fn total(&self) -> Option<u64> {
        self.total
    }

    /// The counters now. Each is exact; they are not read at one instant.
    pub fn read(&self) -> Reading {
        let time = |counter: &AtomicU64| Duration::from_nanos(counter.load(Ordering::Relaxed));
        Reading {
            items_in: self.items_in.load(Ordering::Relaxed),
            items_out: self.items_out.load(Ordering::Relaxed),
            bytes: self.bytes.load(Ordering::Relaxed),
            busy: time(&self.busy),
            wait_in: time(&self.wait_in),
            wait_out: time(&self.wait_out),
            queue: self.queue.load(Ordering::Relaxed),
            skipped: lock(&self.skipped).len() as u64,
        }
    }

    /// Adds bytes read or written.
    pub fn count_bytes(&self, bytes: u64) {
        self.bytes.fetch_add(bytes, Ordering::Relaxed);
    }

    /// Notes a skipped item.
    pub fn skip(&self, skipped: Skipped) {
        lock(&self.skipped).push(skipped);
    }

    /// The items skipped so far, sorted: workers report in no fixed order.
    pub fn skipped(&self) -> Vec<Skipped> {
        let mut all = lock(&self.skipped).clone();
        all.sort();
        all
    }

    /// Takes one of the threads off: the system did not grant it.
    pub(super) fn lacks_worker(&self) {
        self.workers.fetch_sub(1, Ordering::Relaxed);
    }

    /// Counts an item taken, and notes the items that are left in the queue.
    pub(super) fn took(&self, queue: usize) {
        self.items_in.fetch_add(1, Ordering::Relaxed);
        self.set_queue(queue);
    }

    /// Counts an item passed on.
    pub(crate) fn passed(&self) {
        self.items_out.fetch_add(1, Ordering::Relaxed);
    }

    /// Notes the length of the queue before this stage.
    pub(super) fn set_queue(&self, queue: usize) {
        self.queue.store(queue, Ordering::Relaxed);
    }
}

/// One thread's clock: each call puts the time since the last call down to one of three causes.
#[derive(Debug)]
pub(super) struct Clock<'a> {
    meter: &'a Meter,
    since: Instant,
}

impl<'a> Clock<'a> {
    /// Starts now.
    pub(super) fn start(meter: &'a Meter) -> Self {
        Clock { meter, since: Instant::now() }
    }

    /// The time since the last call was work.
    pub(super) fn worked(&mut self) {
        self.lap(&self.meter.busy);
    }

    /// The time since the last call was a wait for input.
    pub(super) fn waited_for_input(&mut self) {
        self.lap(&self.meter.wait_in);
    }

    /// The time since the last call was a wait for output.
    pub(super) fn waited_for_output(&mut self) {
        self.lap(&self.meter.wait_out);
    }

    fn lap(&mut self, counter: &AtomicU64) {
        let now = Instant::now();
        let nanos = u64::try_from((now - self.since).as_nanos()).unwrap_or(u64::MAX);
        counter.fetch_add(nanos, Ordering::Relaxed);
        self.since = now;
    }
}

impl Drop for Clock<'_> {
    fn drop(&mut self) {
        self.worked();
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_clock_puts_every_nanosecond_somewhere() {
        let meter = Meter::new("m", 1, 1, None);
        let before = Instant::now();
        let mut clock = Clock::start(&meter);
        let started = clock.since;
        clock.waited_for_input();
        clock.worked();
        clock.waited_for_output();
        let last = clock.since;
        let r = meter.read();
        assert_eq!(r.busy + r.wait_in + r.wait_out, last - started);
        assert!(started >= before);
    }

    #[test]
    fn skipped_items_are_listed_in_order() {
        let meter = Meter::new("m", 2, 1, None);
        for item in ["b", "a"] {
            meter.skip(Skipped { item: item.into(), why: "torn".into(), replay: format!("gonio x {item}") });
        }
        assert_eq!(meter.skipped().iter().map(|s| s.item.as_str()).collect::<Vec<_>>(), ["a", "b"]);
        assert_eq!(meter.read().skipped, 2);
    }
}
