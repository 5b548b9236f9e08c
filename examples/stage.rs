//! Stages of one's own: a source of numbers, a map that finds which of them are prime, a fold that counts the primes.
//!
//! ```text
//! cargo run --release --example stage -- 10000000
//! ```
#![expect(clippy::print_stdout, reason = "an example shows its results")]

use std::error::Error;
use std::ops::Range;

use gonio::flow::{End, Flow, Fold, Map, Meter, Outlet, Source};
use gonio::{Result, StopSignal};

/// Numbers that a worker takes at a time.
const BATCH: u64 = 10_000;

/// Hands out the numbers below a limit in batches.
struct Numbers(u64);

impl Source for Numbers {
    type Out = Range<u64>;

    fn total(&self) -> Option<u64> {
        Some(self.0.div_ceil(BATCH))
    }

    fn run(self, out: &mut Outlet<'_, Range<u64>>) -> Result<()> {
        let batch = |i: u64| i * BATCH..self.0.min((i + 1) * BATCH);
        (0..self.0.div_ceil(BATCH)).try_for_each(|i| out.send(batch(i)))
    }
}

/// Finds the primes of a batch. Workers share the map, and give the same answer however many there are.
struct Primes;

impl Map for Primes {
    type In = Range<u64>;
    type Out = Vec<u64>;
    type Scratch = ();

    fn scratch(&self) -> Result<()> {
        Ok(())
    }

    fn apply(&self, _: &mut (), batch: Range<u64>, out: &mut Outlet<'_, Vec<u64>>) -> Result<()> {
        let divides = |n: u64| (2..).take_while(move |d| d * d <= n).any(|d| n.is_multiple_of(d));
        out.send(batch.filter(|&n| n > 1 && !divides(n)).collect())
    }
}

/// Counts primes and keeps the last one. Batches come in order, whichever worker is done first.
#[derive(Default)]
struct Count {
    primes: usize,
    last: Option<u64>,
}

impl Fold for Count {
    type In = Vec<u64>;
    type Out = Count;

    fn take(&mut self, primes: Vec<u64>, _: &Meter) -> Result<()> {
        self.primes += primes.len();
        self.last = primes.last().copied().or(self.last);
        Ok(())
    }

    fn finish(self, _: End, _: &Meter) -> Result<Count> {
        Ok(self)
    }
}

fn main() -> Result<(), Box<dyn Error>> {
    let limit: u64 = std::env::args().nth(1).map_or(Ok(1_000_000), |limit| limit.parse())?;
    let workers = std::thread::available_parallelism()?.get();
    let flow = Flow::source(&StopSignal::new(), "numbers", Numbers(limit))
        .map("primes", Primes, workers, 2 * workers)
        .fold("count", Count::default(), 4);
    let meters = flow.meters();
    let Count { primes, last } = flow.run()?;
    println!("{primes} primes below {limit}; the last is {}", last.map_or("none".to_owned(), |last| last.to_string()));
    for meter in meters {
        println!(
            "{:>8}: {} items in, busy for {:.2} s",
            meter.name(),
            meter.read().items_in,
            meter.read().busy.as_secs_f64()
        );
    }
    Ok(())
}
