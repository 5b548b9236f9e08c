//! The budget: which requests are met, which are refused and in which words, and that nobody waits for ever.

use std::thread::{JoinHandle, sleep, yield_now};
use std::time::Duration;

use super::within_watchdog;
use crate::base::Result;
use crate::base::units::Bytes;
use crate::flow::{Budget, Reservation, StopSignal};

fn budget(total: u64) -> Budget {
    Budget::new(Bytes(total), &StopSignal::new())
}

/// Reserves on another thread, and waits until that thread waits.
fn waiting(budget: &Budget, who: &'static str, bytes: u64) -> JoinHandle<Result<Reservation>> {
    let before = budget.waiting();
    let inner = budget.clone();
    let waiter = std::thread::spawn(move || inner.reserve(who, bytes));
    while budget.waiting() == before {
        yield_now();
    }
    waiter
}

#[test]
fn what_is_free_is_given_at_once() {
    // (total, already held, asked)
    let table = [(100, 0, 100), (100, 60, 40), (100, 100, 0), (0, 0, 0), (u64::MAX, u64::MAX - 1, 1)];
    for (total, held, asked) in table {
        within_watchdog(move || {
            let budget = budget(total);
            let first = budget.reserve("first", held).unwrap();
            let second = budget.reserve("second", asked).unwrap();
            assert_eq!((second.bytes(), budget.used(), budget.left()), (asked, held + asked, total - held - asked));
            drop((first, second));
            assert_eq!((budget.used(), budget.left(), budget.peak()), (0, total, held + asked));
        });
    }
}

#[test]
fn what_is_not_free_is_waited_for() {
    for (total, held, asked) in [(100, 60, 41), (100, 1, 100), (u64::MAX, u64::MAX - 1, u64::MAX)] {
        within_watchdog(move || {
            let budget = budget(total);
            let first = budget.reserve("first", held).unwrap();
            let second = waiting(&budget, "second", asked);
            assert_eq!(budget.used(), held);
            drop(first);
            assert_eq!(second.join().unwrap().unwrap().bytes(), asked);
        });
    }
}

#[test]
fn reservations_shrink_and_are_given_back() {
    let budget = budget(100);
    let mut a = budget.reserve("a", 60).unwrap();
    a.shrink(20);
    assert_eq!((a.bytes(), budget.used()), (40, 40));
    a.shrink(1000);
    assert_eq!((a.bytes(), budget.used(), budget.peak()), (0, 0, 60));
}

#[test]
fn more_than_all_is_an_error_and_no_hang() {
    let why = within_watchdog(|| budget(100).reserve("batch", 101).unwrap_err()).to_string();
    assert_eq!(why, "batch needs 101 B of memory, and the whole run has 100 B: raise `[run] memory`");
}

#[test]
fn a_refusal_says_who_and_how_much() {
    let budget = budget(4 << 20);
    let _held = budget.reserve("process", 3 << 20).unwrap();
    let why = budget.missing("cast", 2 << 20).to_string();
    assert_eq!(why, "cast needs 3 MiB of memory, and only 1 MiB is left: raise `[run] memory` by at least 2 MiB");
}

#[test]
fn those_who_wait_are_served_in_order() {
    within_watchdog(|| {
        let budget = budget(100);
        let mut all = budget.reserve("all", 100).unwrap();
        let large = waiting(&budget, "large", 80);
        all.shrink(50);
        let small = waiting(&budget, "small", 10);
        assert_eq!(budget.reserve("nothing", 0).unwrap().bytes(), 0, "nothing is never waited for");
        sleep(Duration::from_millis(20));
        assert_eq!(budget.waiting(), 2, "50 would do for the small one, but the large one came first");
        all.shrink(30);
        let held = large.join().unwrap().unwrap();
        assert!(held.bytes() == 80 && budget.waiting() == 1);
        drop(all);
        let small = small.join().unwrap().unwrap();
        assert_eq!(budget.used(), held.bytes() + small.bytes());
    });
}

#[test]
fn a_halt_ends_a_wait_and_those_behind_move_up() {
    within_watchdog(|| {
        let stop = StopSignal::new();
        let budget = Budget::new(Bytes(10), &stop);
        let all = budget.reserve("all", 10).unwrap();
        let waiters: Vec<_> = (0..4).map(|_| waiting(&budget, "waits", 5)).collect();
        stop.halt(crate::base::Error::Interrupted);
        assert!(waiters.into_iter().all(|waiter| waiter.join().unwrap().is_err_and(|why| why.is_interrupt())));
        assert_eq!(budget.waiting(), 0);
        drop(all);
        assert_eq!(budget.used(), 0);
    });
}
