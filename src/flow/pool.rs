//! The number of workers of a run. Pure functions, so a plan and a run agree.

use super::order;

/// The threads to use: as many as asked for, or all that are available where 0 is asked for.
pub fn threads(asked: usize, available: usize) -> usize {
    if asked == 0 { available.max(1) } else { asked }
}

/// The threads that this process may run at once, or 1 where the system does not say.
pub fn available() -> usize {
    std::thread::available_parallelism().map_or(1, usize::from)
}

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
    fn a_map_holds_its_queue_and_twice_its_workers_less_one() {
        assert_eq!([(1, 0), (1, 4), (2, 4), (8, 2)].map(|(w, q)| most_held(w, q)), [1, 5, 7, 17]);
    }
}
