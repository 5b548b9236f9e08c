//! Stopping: whichever stage fails, all threads join, and the first cause is reported. `Flow::run` joins its scope: that
//! it returns proves that every thread has ended.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};
use std::thread::sleep;
use std::time::Duration;

use super::mock::{Each, From, Gather, count, endless, gather, pass};
use super::within_watchdog;
use crate::base::{Error, Result};
use crate::flow::{Budget, End, Flow, Fold, Meter, Outlet, StopSignal};

/// How a stage fails.
#[derive(Debug, Clone, Copy)]
enum Fault {
    Error,
    Panic,
}

impl Fault {
    fn strike(self) -> Result<()> {
        match self {
            Fault::Error => Err(Error::invalid("on purpose")),
            Fault::Panic => panic!("on purpose"),
        }
    }

    fn is(self, why: &Error, stage: &str) -> bool {
        match self {
            Fault::Error => why.to_string() == "on purpose",
            Fault::Panic => why.to_string() == format!("stage {stage} panicked: on purpose"),
        }
    }
}

#[test]
fn any_stage_may_fail_and_all_stop() {
    for fault in [Fault::Error, Fault::Panic] {
        for stage in ["source", "map", "fold"] {
            for at in [0, 1, 37] {
                for workers in [1, 2, 8] {
                    within_watchdog(move || {
                        let strike =
                            move |here: &str, n: u64| if here == stage && n == at { fault.strike() } else { Ok(()) };
                        let source = From(move |out: &mut Outlet<'_, u64>| {
                            (0..).try_for_each(|n| {
                                strike("source", n)?;
                                out.send(n)
                            })
                        });
                        let map = Each(move |n, out: &mut Outlet<'_, u64>| {
                            strike("map", n)?;
                            out.send(n)
                        });
                        let fold = Gather(move |n| strike("fold", n), Vec::new());
                        let stop = StopSignal::new();
                        let flow = Flow::source(&stop, "source", source)
                            .map("before", pass(), workers, 1)
                            .map("map", map, workers, 1)
                            .map("after", pass(), workers, 1)
                            .fold("fold", fold, 1);
                        let why = flow.run().unwrap_err();
                        assert!(fault.is(&why, stage), "{stage} at {at}, {workers} workers: {why}");
                        assert!(stop.halted());
                    });
                }
            }
        }
    }
}

/// Counts how often it finished, and fails or panics there if told to.
struct Finishes {
    finished: Arc<AtomicU64>,
    fault: Option<Fault>,
}

impl Fold for Finishes {
    type In = u64;
    type Out = End;

    fn take(&mut self, _: u64, _: &Meter) -> Result<()> {
        Ok(())
    }

    fn finish(self, end: End, _: &Meter) -> Result<End> {
        self.finished.fetch_add(1, Ordering::SeqCst);
        self.fault.map_or(Ok(()), Fault::strike)?;
        Ok(end)
    }
}

#[test]
fn a_fold_may_fail_as_it_finishes() {
    for fault in [Fault::Error, Fault::Panic] {
        let fold = Finishes { finished: Arc::default(), fault: Some(fault) };
        let flow = Flow::source(&StopSignal::new(), "count", count(9)).fold("fold", fold, 1);
        let why = within_watchdog(|| flow.run().unwrap_err());
        assert!(fault.is(&why, "fold"), "{why}");
    }
}

#[test]
fn no_fold_finishes_on_half_an_input() {
    // A source that dies right after its last item looks most like one that is done.
    for _ in 0..200 {
        let finished = Arc::new(AtomicU64::new(0));
        let fold = Finishes { finished: Arc::clone(&finished), fault: None };
        let source = From(|out: &mut Outlet<'_, u64>| out.send(0).and_then(|()| Fault::Error.strike()));
        let flow = Flow::source(&StopSignal::new(), "source", source).map("pass", pass(), 2, 1).fold("fold", fold, 1);
        within_watchdog(|| flow.run().unwrap_err());
        assert_eq!(finished.load(Ordering::SeqCst), 0);
    }
}

#[test]
fn a_failing_scratch_is_a_cause() {
    struct NoMemory;
    impl crate::flow::Map for NoMemory {
        type In = u64;
        type Out = u64;
        type Scratch = ();
        fn scratch(&self) -> Result<()> {
            Err(Error::invalid("no memory for scratch"))
        }
        fn apply(&self, (): &mut (), n: u64, out: &mut Outlet<'_, u64>) -> Result<()> {
            out.send(n)
        }
    }
    let flow =
        Flow::source(&StopSignal::new(), "endless", endless()).map("none", NoMemory, 4, 1).fold("g", gather(), 1);
    assert_eq!(within_watchdog(|| flow.run().unwrap_err()).to_string(), "no memory for scratch");
}

#[test]
fn a_consequence_put_into_context_is_still_no_cause() {
    within_watchdog(|| {
        let source = From(|out: &mut Outlet<'_, u64>| {
            (0..).try_for_each(|n| out.send(n).map_err(|why| why.doing("listing frames")))
        });
        let fold = Gather(|n| if n == 3 { Err(Error::invalid("disk full")) } else { Ok(()) }, Vec::new());
        let flow = Flow::source(&StopSignal::new(), "source", source).map("pass", pass(), 2, 1).fold("fold", fold, 1);
        assert_eq!(flow.run().unwrap_err().to_string(), "disk full");
    });
}

#[test]
fn a_drain_folds_what_is_in_flight_and_then_says_interrupted() {
    for workers in [1, 2, 8] {
        within_watchdog(move || {
            let stop = StopSignal::new();
            let sent = Arc::new(AtomicU64::new(0));
            let (counter, trip) = (Arc::clone(&sent), stop.clone());
            let source = From(move |out: &mut Outlet<'_, u64>| {
                (0..).try_for_each(|n| {
                    out.send(n)?;
                    counter.fetch_add(1, Ordering::SeqCst);
                    Ok(())
                })
            });
            let folded = Arc::new(AtomicU64::new(0));
            let ended = Arc::new(AtomicBool::new(false));
            let fold = Watched { folded: Arc::clone(&folded), ended: Arc::clone(&ended), trip };
            let flow = Flow::source(&stop, "source", source).map("pass", pass(), workers, 2).fold("fold", fold, 2);
            let why = flow.run().unwrap_err();
            assert!(why.is_interrupt() && !stop.halted(), "{why}");
            assert!(ended.load(Ordering::SeqCst), "the fold has finished");
            assert_eq!(folded.load(Ordering::SeqCst), sent.load(Ordering::SeqCst), "all that was sent is folded");
            // And a flow that follows does nothing, but says the same.
            let next = Flow::source(&stop, "next", count(3)).fold("gather", gather(), 1);
            assert!(next.run().unwrap_err().is_interrupt());
        });
    }
}

/// Drains the run at its tenth item.
struct Watched {
    folded: Arc<AtomicU64>,
    ended: Arc<AtomicBool>,
    trip: StopSignal,
}

impl Fold for Watched {
    type In = u64;
    type Out = ();

    fn take(&mut self, _: u64, _: &Meter) -> Result<()> {
        if self.folded.fetch_add(1, Ordering::SeqCst) == 9 {
            self.trip.drain();
        }
        Ok(())
    }

    fn finish(self, end: End, _: &Meter) -> Result<()> {
        assert_eq!(end, End::Drained);
        self.ended.store(true, Ordering::SeqCst);
        Ok(())
    }
}

#[test]
fn a_drain_after_the_last_item_changes_nothing() {
    let stop = StopSignal::new();
    let trip = stop.clone();
    let source = From(move |out: &mut Outlet<'_, u64>| {
        (0..5).try_for_each(|n| out.send(n))?;
        trip.drain();
        Ok(())
    });
    let flow = Flow::source(&stop, "source", source).fold("gather", gather(), 1);
    assert_eq!(within_watchdog(|| flow.run().unwrap()), (vec![0, 1, 2, 3, 4], End::Complete));
}

#[test]
fn a_source_that_asks_and_returns_counts_as_cut() {
    let stop = StopSignal::new();
    stop.drain();
    let source = From(|out: &mut Outlet<'_, u64>| {
        assert!(out.stopping());
        Ok(())
    });
    let flow = Flow::source(&stop, "source", source).fold("gather", gather(), 1);
    assert!(within_watchdog(|| flow.run().unwrap_err()).is_interrupt());
}

#[test]
fn an_error_during_a_drain_is_what_is_reported() {
    within_watchdog(|| {
        let stop = StopSignal::new();
        let trip = stop.clone();
        let fold = Gather(
            move |n| {
                // Not before: the source may stop at once.
                if n < 2 {
                    return Ok(());
                }
                trip.drain();
                Err(Error::invalid("torn"))
            },
            Vec::new(),
        );
        let flow = Flow::source(&stop, "endless", endless()).map("pass", pass(), 2, 4).fold("fold", fold, 4);
        assert_eq!(flow.run().unwrap_err().to_string(), "torn");
    });
}

#[test]
fn a_halt_from_outside_ends_every_wait() {
    within_watchdog(|| {
        let stop = StopSignal::new();
        let budget = Budget::new(crate::base::units::Bytes(10), &stop);
        let all = budget.reserve("test", 10).unwrap();
        let inner = budget.clone();
        // The fold waits for bytes that nobody gives back, the workers for space, the source too.
        let fold = Gather(move |_| inner.reserve("fold", 1).map(drop), Vec::new());
        let flow = Flow::source(&stop, "endless", endless()).map("pass", pass(), 3, 1).fold("fold", fold, 1);
        let running = std::thread::spawn(move || flow.run());
        sleep(Duration::from_millis(20));
        stop.halt(Error::invalid("enough"));
        assert_eq!(running.join().unwrap().unwrap_err().to_string(), "enough");
        assert_eq!(budget.used(), all.bytes());
    });
}

#[test]
fn threads_carry_their_stages_names() {
    within_watchdog(|| {
        let map = Each(|n, out: &mut Outlet<'_, u64>| {
            assert!(std::thread::current().name().is_some_and(|name| name == "map-0" || name == "map-1"));
            out.send(n)
        });
        let fold = Gather(
            |_| {
                assert_eq!(std::thread::current().name(), Some("fold"));
                Ok(())
            },
            Vec::new(),
        );
        let flow = Flow::source(&StopSignal::new(), "source", count(20)).map("map", map, 2, 1).fold("fold", fold, 1);
        flow.run().unwrap();
    });
}
