//! The number of workers of a run, and the threads among which work outside of flows is shared out.
//!
//! rayon has a pool for the whole process, whose size nobody here decides. Nothing may run there: whoever calls code that shares
//! out work by rayon calls it within [`share`].

use std::thread::sleep;
use std::time::Duration;

use rayon::{ThreadBuilder, ThreadPoolBuilder};

use super::{order, spawn};
use crate::base::{Error, Result};

/// The threads to use: as many as asked for, or all that are available where 0 is asked for.
pub fn threads(asked: usize, available: usize) -> usize {
    if asked == 0 { available.max(1) } else { asked }
}

/// The threads that this process may run at once, or 1 where the system does not say.
pub fn available() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

/// Does work that rayon shares out, on so many threads of its own, which end with it; on fewer where the system grants no more.
///
/// # Errors
/// The system grants no thread at all.
pub fn share<R: Send>(threads: usize, work: impl FnOnce() -> R + Send) -> Result<R> {
    let (mut count, mut work, mut waits) = (threads.max(1), Some(work), WAITS);
    loop {
        let pool = ThreadPoolBuilder::new().num_threads(count).thread_name(|at| format!("share-{at}"));
        let done = pool.build_scoped(ThreadBuilder::run, |pool| work.take().map(|work| pool.install(work)));
        match done {
            Ok(Some(result)) => return Ok(result),
            Ok(None) => return Err(Error::invalid("work was shared out twice")),
            Err(_) if count > 1 => count /= 2,
            // Threads that ended a moment ago still count against a limit.
            Err(_) if waits > 0 => {
                waits -= 1;
                sleep(WAIT);
            }
            Err(why) => return Err(spawn::refused("share-0", &why)),
        }
    }
}

/// Waits for a thread to be granted, and the time of each.
const WAITS: usize = 5;
const WAIT: Duration = Duration::from_millis(10);

/// The most items that a map with at most one output per item and the queue before it hold at once. A plan computes
/// memory from it.
pub fn most_held(workers: usize, queue: usize) -> usize {
    queue + order::held(workers.max(1))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zero_means_all() {
        for (asked, available, got) in [(0, 8, 8), (0, 0, 1), (3, 8, 3), (16, 2, 16)] {
            assert_eq!(threads(asked, available), got, "{asked} of {available}");
        }
        assert!(available() >= 1);
    }

    #[test]
    fn shared_work_runs_on_named_threads_that_end_with_it() {
        use rayon::prelude::*;
        use std::collections::BTreeSet;
        let name = |_| std::thread::current().name().map(str::to_owned);
        for threads in [1, 3] {
            let names: BTreeSet<_> = share(threads, || (0..1000).into_par_iter().map(name).collect()).unwrap();
            let wanted = (0..threads).map(|at| Some(format!("share-{at}"))).collect();
            assert!(names.is_subset(&wanted) && !names.is_empty(), "{names:?}");
            assert_eq!(share(threads, rayon::current_num_threads).unwrap(), threads);
        }
        assert_eq!(share(0, rayon::current_num_threads).unwrap(), 1);
    }

    #[test]
    fn a_map_holds_its_queue_and_twice_its_workers_less_one() {
        assert_eq!([(1, 0), (1, 4), (2, 4), (8, 2)].map(|(w, q)| most_held(w, q)), [1, 5, 7, 17]);
    }
}
