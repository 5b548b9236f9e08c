//! The budget: what is given, what is refused and in which words, and that nobody waits for ever.

use std::thread::sleep;
use std::time::Duration;

use super::within_watchdog;
use crate::base::units::Bytes;
use crate::flow::{Budget, StopSignal};

fn budget(total: u64) -> Budget {
    Budget::new(Bytes(total), &StopSignal::new())
}

#[test]
fn what_is_given_and_refused() {
    // (total, already held, asked, given)
    let table = [
        (100, 0, 100, true),
        (100, 0, 101, false),
        (100, 60, 40, true),
        (100, 60, 41, false),
        (100, 100, 0, true),
        (0, 0, 0, true),
        (0, 0, 1, false),
        (u64::MAX, u64::MAX - 1, u64::MAX, false),
        (u64::MAX, u64::MAX - 1, 1, true),
    ];
    for (total, held, asked, given) in table {
        let budget = budget(total);
        let first = budget.try_reserve("first", held).unwrap();
        let second = budget.try_reserve("second", asked);
        assert_eq!(second.is_ok(), given, "{asked} of {total}, {held} held");
        assert_eq!(budget.used(), held + if given { asked } else { 0 });
        drop((first, second));
        assert_eq!((budget.used(), budget.holders().len()), (0, 0));
    }
}

#[test]
fn a_refusal_says_who_and_how_much() {
    let budget = budget(4 << 20);
    let mut gather = budget.try_reserve("gather", 3 << 20).unwrap();
    let refusal = gather.grow(2 << 20).unwrap_err();
    let said = "gather asked for 2 MiB of memory and holds 3 MiB; of 4 MiB in all, 1 MiB are left";
    assert_eq!(refusal.to_string(), said);
    assert_eq!(gather.bytes(), 3 << 20, "a refused holder holds what it held");
    assert_eq!(crate::base::Error::from(refusal).to_string(), format!("{said}: raise `[run] memory`"));
}

#[test]
fn reservations_grow_shrink_and_are_given_back() {
    let budget = budget(100);
    let mut a = budget.reserve("a", 10).unwrap();
    a.grow(50).unwrap();
    assert_eq!(budget.holders(), [("a".to_owned(), 60)]);
    a.shrink(20);
    a.shrink(1000);
    assert_eq!((a.bytes(), budget.used(), budget.peak()), (0, 0, 60));
}

#[test]
fn more_than_all_is_an_error_and_no_hang() {
    let why = within_watchdog(|| budget(100).reserve("batch", 101).unwrap_err());
    assert!(why.to_string().starts_with("batch asked for 101 B of memory and holds 0 B; of 100 B in all"), "{why}");
}

#[test]
fn those_who_wait_are_served_in_order() {
    within_watchdog(|| {
        let budget = budget(100);
        let mut all = budget.reserve("all", 100).unwrap();
        let (done, order) = crossbeam_channel::unbounded();
        let wait = |who: &'static str, bytes| {
            let (asked, done) = (budget.clone(), done.clone());
            let waiter = std::thread::spawn(move || {
                let held = asked.reserve(who, bytes).unwrap();
                done.send(who).unwrap();
                held
            });
            // Until it stands in the queue.
            while !budget.try_reserve("probe", 1).is_err_and(|r| r.waiting > usize::from(who == "small")) {
                std::thread::yield_now();
            }
            waiter
        };
        let large = wait("large", 80);
        let small = wait("small", 10);
        all.shrink(50);
        sleep(Duration::from_millis(20));
        assert!(order.is_empty(), "50 would do for the small one, but the large one came first");
        let refusal = all.grow(1).unwrap_err();
        assert!(refusal.to_string().ends_with("50 B are left and 2 wait for more"), "{refusal}");
        all.shrink(30);
        let held = large.join().unwrap();
        assert_eq!(order.recv().unwrap(), "large");
        drop(all);
        let small = small.join().unwrap();
        assert_eq!(budget.used(), held.bytes() + small.bytes());
    });
}

#[test]
fn a_halt_ends_a_wait_and_those_behind_move_up() {
    within_watchdog(|| {
        let stop = StopSignal::new();
        let budget = Budget::new(Bytes(10), &stop);
        let all = budget.reserve("all", 10).unwrap();
        let waiters: Vec<_> = (0..4)
            .map(|_| {
                let budget = budget.clone();
                std::thread::spawn(move || budget.reserve("waits", 5).is_err_and(|e| e.is_interrupt()))
            })
            .collect();
        sleep(Duration::from_millis(10));
        stop.halt(crate::base::Error::Interrupted);
        assert!(waiters.into_iter().all(|w| w.join().unwrap()));
        drop(all);
        assert_eq!(budget.used(), 0);
    });
}
