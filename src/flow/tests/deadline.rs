//! The deadline of a stop: a drain becomes a halt, and a halt that does not end is told.

use std::convert::Infallible;
use std::sync::atomic::{AtomicBool, Ordering};
use std::time::{Duration, Instant};

use crossbeam_channel::bounded;

use super::mock::{Each, endless, gather};
use super::within_watchdog;
use crate::base::Result;
use crate::flow::deadline::{Came, HALT, LOOK, watch};
use crate::flow::{Flow, Outlet, StopSignal};

/// A flow whose map never gives up its third item while `stuck`, or else waits where a halt wakes it.
fn drained(grace: Duration, stuck: &'static AtomicBool) -> (Came, bool, Duration) {
    within_watchdog(move || {
        let (stop, (over, watched)) = (StopSignal::new(), bounded::<Infallible>(0));
        let (_never, never) = bounded::<u8>(0);
        let (inner, trip) = (stop.again(), stop.clone());
        let map = Each(move |n, out: &mut Outlet<'_, u64>| -> Result<()> {
            if n == 3 {
                trip.drain();
                while stuck.load(Ordering::SeqCst) {
                    std::thread::sleep(LOOK);
                }
                inner.recv(&never)?;
            }
            out.send(n)
        });
        let attempt = stop.again();
        let flow = Flow::source(&attempt, "endless", endless()).map("slow", map, 2, 1).fold("gather", gather(), 1);
        std::thread::scope(|scope| {
            let running = scope.spawn(move || {
                let ended = flow.run();
                drop(over);
                ended.is_err_and(|why| why.is_interrupt())
            });
            let begun = Instant::now();
            let came = watch(&stop, grace, &watched);
            let took = begun.elapsed();
            stuck.store(false, Ordering::SeqCst);
            (came, running.join().unwrap(), took)
        })
    })
}

#[test]
fn a_drain_that_does_not_end_in_time_becomes_a_halt() {
    static STUCK: AtomicBool = AtomicBool::new(false);
    let (came, interrupted, took) = drained(Duration::from_millis(100), &STUCK);
    assert_eq!((came, interrupted), (Came::ToAnEnd, true));
    assert!((Duration::from_millis(100)..HALT).contains(&took), "{took:?}");
}

#[test]
fn a_thread_that_never_returns_does_not_keep_the_watch() {
    static STUCK: AtomicBool = AtomicBool::new(true);
    let (came, interrupted, took) = drained(Duration::ZERO, &STUCK);
    assert_eq!((came, interrupted), (Came::ToNone, true), "the thread was freed afterwards");
    assert!(took >= HALT, "{took:?}");
}
