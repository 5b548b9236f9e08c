//! How fast a stage is: right from the first reading on, and never zero while something moves.

use std::collections::VecDeque;
use std::time::{Duration, Instant};

use super::print::short;

/// The time that a rate is measured over, at least, once it has passed.
const OVER: Duration = Duration::from_secs(10);

/// The readings that the rate of one stage is measured from.
#[derive(Debug, Clone, Default)]
pub(super) struct Rate {
    of: String,
    /// Numbers of items and when each was first seen, from the start of the phase on.
    seen: VecDeque<(Instant, u64)>,
}

impl Rate {
    /// The items a second of a stage that has passed on so many since its phase began: since the last reading that is old enough
    /// to measure from and has fewer.
    pub(super) fn update(&mut self, of: &str, items: u64, began: Instant, now: Instant) -> f64 {
        if self.of != of {
            *self = Rate { of: of.to_owned(), seen: VecDeque::from([(began, 0)]) };
        }
        let tells = |&(then, before): &(Instant, u64)| before < items && now.saturating_duration_since(then) >= OVER;
        while self.seen.get(1).is_some_and(tells) {
            self.seen.pop_front();
        }
        if self.seen.back().is_some_and(|&(_, before)| before < items) {
            self.seen.push_back((now, items));
        }
        let (then, before) = self.seen.front().copied().unwrap_or((began, 0));
        let seconds = now.saturating_duration_since(then).as_secs_f64();
        if seconds > 0.0 { items.saturating_sub(before) as f64 / seconds } else { 0.0 }
    }
}

/// A rate as people read it: by the second, or by the hour where that would be nearly nothing.
pub(super) fn per_time(per_second: f64) -> String {
    if per_second > 0.0 && per_second < 0.1 {
        format!("{}/h", short(3600.0 * per_second))
    } else {
        format!("{}/s", short(per_second))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rate_is_right_at_once_and_follows_and_starts_anew_with_another_stage() {
        let (mut rate, start) = (Rate::default(), Instant::now());
        let at = |seconds: f64| start + Duration::from_secs_f64(seconds);
        assert_eq!(rate.update("a", 0, start, start), 0.0);
        assert_eq!(rate.update("a", 30, start, at(3.0)), 10.0, "the first line");
        assert_eq!(rate.update("a", 330, start, at(33.0)), 10.0);
        assert_eq!(rate.update("a", 360, start, at(63.0)), 1.0, "of now, not since the start");
        for quarter in 253..=400 {
            rate.update("a", 360 + 5 * (quarter - 252), start, at(0.25 * quarter as f64));
        }
        let now = rate.update("a", 360 + 5 * 148, start, at(100.0));
        assert!((now - 20.0).abs() < 1e-9, "{now}");
        assert!(rate.seen.len() < 50, "only what is needed is kept");
        assert_eq!(rate.update("b", 4, at(100.0), at(102.0)), 2.0);
    }

    #[test]
    fn what_moves_slowly_moves() {
        let (mut rate, start) = (Rate::default(), Instant::now());
        let at = |seconds: u64| start + Duration::from_secs(seconds);
        for minute in 0..10 {
            rate.update("a", 1 + minute / 5, start, at(60 * minute));
        }
        let slow = rate.update("a", 2, start, at(600));
        assert!(slow > 0.0, "nothing moved for four minutes, and something before: {slow}");
        assert_eq!(
            (per_time(0.0), per_time(0.01), per_time(12.34)),
            ("0.00/s".into(), "36.0/h".into(), "12.3/s".into())
        );
    }
}
