//! Order: the same sequence for any number of workers and any schedule.

use std::thread::sleep;
use std::time::Duration;

use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::mock::{Each, From, Gather, count, gather};
use super::within_watchdog;
use crate::flow::{End, Flow, Outlet, Skipped, StopSignal};

/// Item n gives n % 4 outputs: none, one and many, all in the same flow.
fn outputs(n: u64) -> impl Iterator<Item = u64> {
    (0..n % 4).map(move |k| 10 * n + k)
}

/// A pause that is the same for the same seed and item, but not for the next.
fn pause(seed: u64, n: u64) {
    let micros = Pcg64Mcg::seed_from_u64(seed ^ n.wrapping_mul(0x9e37_79b9_7f4a_7c15)).random_range(0..120u64);
    if micros > 60 {
        sleep(Duration::from_micros(micros));
    }
}

#[test]
fn order_is_kept_under_any_schedule() {
    let wanted: Vec<u64> = (0..200).flat_map(outputs).flat_map(outputs).collect();
    for workers in [1, 2, 8] {
        for seed in 0..6 {
            let wanted = wanted.clone();
            within_watchdog(move || {
                let split = |salt: u64| {
                    Each(move |n, out: &mut Outlet<'_, u64>| {
                        pause(seed + salt, n);
                        outputs(n).try_for_each(|o| {
                            pause(seed + salt, o);
                            out.send(o)
                        })
                    })
                };
                let queue = usize::try_from(seed % 3).unwrap();
                let flow = Flow::source(&StopSignal::new(), "count", count(200))
                    .map("split", split(100), workers, queue)
                    .map("again", split(200), workers, queue + 1)
                    .fold("gather", gather(), queue);
                let meters = flow.meters();
                assert_eq!(flow.run().unwrap(), (wanted.clone(), End::Complete), "{workers} workers, seed {seed}");
                let counts = meters.iter().map(|m| (m.read().items_in, m.read().items_out)).collect::<Vec<_>>();
                let middle = (0..200).flat_map(outputs).count() as u64;
                let last = wanted.len() as u64;
                assert_eq!(counts, [(0, 200), (200, middle), (middle, last), (last, 0)]);
                assert!(meters.iter().all(|m| m.read().queue == 0));
            });
        }
    }
}

#[test]
fn a_slow_first_item_does_not_let_others_pass() {
    within_watchdog(|| {
        let slow = Each(|n, out: &mut Outlet<'_, u64>| {
            if n == 0 {
                sleep(Duration::from_millis(30));
            }
            out.send(n)
        });
        let flow = Flow::source(&StopSignal::new(), "count", count(50)).map("slow", slow, 4, 2);
        assert_eq!(flow.fold("gather", gather(), 1).run().unwrap().0, (0..50).collect::<Vec<_>>());
    });
}

#[test]
fn stages_may_borrow_and_skip() {
    let mesh = [5u64, 7, 9];
    let source = From(|out: &mut Outlet<'_, u64>| mesh.iter().try_for_each(|&n| out.send(n)));
    let odd = Each(|n, out: &mut Outlet<'_, u64>| {
        out.count_bytes(8);
        if n == 7 {
            out.skip(Skipped { item: "7".into(), why: "unlucky".into(), replay: "count --only 7".into() });
            return Ok(());
        }
        out.send(mesh.iter().position(|&m| m == n).unwrap() as u64)
    });
    let mut seen = 0;
    let fold = Gather(
        |_| {
            seen += 1;
            Ok(())
        },
        Vec::new(),
    );
    let flow = Flow::source(&StopSignal::new(), "frames", source).map("odd", odd, 2, 1).fold("gather", fold, 1);
    let meters = flow.meters();
    assert_eq!(flow.run().unwrap().0, [0, 2]);
    assert_eq!(seen, 2);
    assert_eq!((meters[1].skipped()[0].item.as_str(), meters[1].read().bytes), ("7", 24));
}

#[test]
fn nothing_in_nothing_out() {
    let flow = Flow::source(&StopSignal::new(), "count", count(0)).map("pass", super::mock::pass(), 3, 0);
    assert_eq!(flow.fold("gather", gather(), 0).run().unwrap(), (vec![], End::Complete));
}
