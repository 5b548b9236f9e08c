//! Bounds: the number of items that a source makes while the fold takes none.

use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::thread::{sleep, yield_now};
use std::time::Duration;

use super::mock::{Each, From, Gather, pass};
use super::within_watchdog;
use crate::flow::{Flow, Outlet, StopSignal, pool};

/// Runs a flow whose fold stops at its first item, and waits until all stages stop: the number of items that the source
/// has made by then, and the numbers of items in the queues.
fn made_while_the_fold_stands(workers: usize, queues: [usize; 2], per_item: u64, expected: u64) -> (u64, [usize; 2]) {
    within_watchdog(move || {
        let made = Arc::new(AtomicU64::new(0));
        let counter = Arc::clone(&made);
        let source = From(move |out: &mut Outlet<'_, u64>| {
            (0..100).try_for_each(|n| {
                counter.fetch_add(1, Ordering::SeqCst);
                out.send(n)
            })
        });
        let (open, gate) = crossbeam_channel::bounded::<()>(0);
        let fold = Gather(
            move |_| {
                gate.recv().ok();
                Ok(())
            },
            Vec::new(),
        );
        let many = Each(move |n, out: &mut Outlet<'_, u64>| (0..per_item).try_for_each(|k| out.send(n + k)));
        let flow = Flow::source(&StopSignal::new(), "count", source)
            .map("many", many, workers, queues[0])
            .fold("gather", fold, queues[1]);
        let meters = flow.meters();
        let running = std::thread::spawn(move || flow.run());
        while made.load(Ordering::SeqCst) < expected {
            yield_now();
        }
        // Long enough for one too many to show; never too short for a right one.
        sleep(Duration::from_millis(40));
        let seen = (made.load(Ordering::SeqCst), [meters[1].read().queue, meters[2].read().queue]);
        drop(open);
        assert_eq!(running.join().unwrap().unwrap().0.len() as u64, 100 * per_item);
        assert!(meters.iter().all(|m| !m.read().busy.is_zero()) && !meters[0].read().wait_out.is_zero());
        seen
    })
}

#[test]
fn exactly_so_many_items_are_buffered() {
    for (workers, queues) in [(1, [1, 1]), (2, [3, 2]), (8, [2, 5]), (3, [0, 0])] {
        // One in the source's hands, the first queue and the map, the second queue, one in the fold's hands.
        let expected = 1 + pool::most_held(workers, queues[0]) + queues[1] + 1;
        let (made, queued) = made_while_the_fold_stands(workers, queues, 1, expected as u64);
        assert_eq!((made, queued), (expected as u64, queues), "{workers} workers, queues {queues:?}");
    }
}

#[test]
fn a_map_that_gives_many_holds_no_more() {
    // The fold and its queue of 1 hold two of the first item's three outputs; the third is in the first worker's hands.
    // The second worker waits with its second output, so only two items of the three that may be are in the map.
    let expected = 1 + 2 + 2;
    assert_eq!(made_while_the_fold_stands(2, [2, 1], 3, expected), (expected, [2, 1]));
}

#[test]
fn a_map_that_gives_nothing_runs_on() {
    // 100 items pass although nothing comes out.
    assert_eq!(made_while_the_fold_stands(4, [1, 1], 0, 100).0, 100);
}

#[test]
fn two_maps_in_a_row_hold_their_sum() {
    within_watchdog(|| {
        let stop = StopSignal::new();
        let (open, gate) = crossbeam_channel::bounded::<()>(0);
        let fold = Gather(
            move |_| {
                gate.recv().ok();
                Ok(())
            },
            Vec::new(),
        );
        let flow = Flow::source(&stop, "count", super::mock::count(500))
            .map("a", pass(), 2, 3)
            .map("b", pass(), 4, 1)
            .fold("gather", fold, 2);
        let meters = flow.meters();
        let running = std::thread::spawn(move || flow.run());
        let expected = (pool::most_held(2, 3) + pool::most_held(4, 1) + 2 + 1) as u64;
        while meters[0].read().items_out < expected {
            yield_now();
        }
        sleep(Duration::from_millis(40));
        assert_eq!(meters[0].read().items_out, expected);
        drop(open);
        running.join().unwrap().unwrap();
    });
}
