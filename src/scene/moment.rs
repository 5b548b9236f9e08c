//! A moment, as a clock showed it.

use std::fmt;

/// A date and a time of day, to the second, and the clock's zone where it is known.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Moment {
    /// Seconds from noon of 1 January 2000, as the clock counts them.
    pub clock: i64,
    /// Minutes that the clock is ahead of UTC, where that is known.
    pub zone: Option<i32>,
}

/// Days from 1 January 1970 to 1 January 2000.
const TO_2000: i64 = 10_957;

const DAY: i64 = 86_400;
const NOON: i64 = DAY / 2;

impl Moment {
    /// A moment of year, month and day at hour, minute and second; a leap second is the second after it. `None` if a calendar
    /// does not have it.
    pub fn new(date: [i64; 3], time: [i64; 3], zone: Option<i32>) -> Option<Moment> {
        let days = days(date);
        let [hour, minute, second] = time;
        let is_time = (0..24).contains(&hour) && (0..60).contains(&minute) && (0..=60).contains(&second);
        let is_zone = zone.is_none_or(|minutes| minutes.abs() < 24 * 60);
        let clock = (days - TO_2000) * DAY - NOON + 3600 * hour + 60 * minute + second;
        ((1..=9999).contains(&date[0]) && self::date(days) == date && is_time && is_zone)
            .then_some(Moment { clock, zone })
    }

    /// Seconds from noon of 1 January 2000 UTC, where the zone is known.
    pub fn utc(self) -> Option<i64> {
        self.zone.map(|minutes| self.clock - 60 * i64::from(minutes))
    }

    /// The moment on a clock of this zone.
    pub fn in_zone(self, minutes: i32) -> Moment {
        Moment { zone: Some(minutes), ..self }
    }
}

/// Days from 1 January 1970 to a date (H. Hinnant, chrono-compatible low-level date algorithms): years begin in March, so that
/// the leap day is the last.
fn days([year, month, day]: [i64; 3]) -> i64 {
    let (year, month) = if month > 2 { (year, month - 3) } else { (year - 1, month + 9) };
    let (era, of_era) = (year.div_euclid(400), year.rem_euclid(400));
    let of_year = (153 * month + 2) / 5 + day - 1;
    era * 146_097 + of_era * 365 + of_era / 4 - of_era / 100 + of_year - 719_468
}

/// The date so many days after 1 January 1970; undoes [`days`].
fn date(days: i64) -> [i64; 3] {
    let days = days + 719_468;
    let (era, of_era) = (days.div_euclid(146_097), days.rem_euclid(146_097));
    let year = (of_era - of_era / 1460 + of_era / 36_524 - of_era / 146_096) / 365;
    let of_year = of_era - (365 * year + year / 4 - year / 100);
    let month = (5 * of_year + 2) / 153;
    let day = of_year - (153 * month + 2) / 5 + 1;
    let (year, month) = if month < 10 { (year, month + 3) } else { (year + 1, month - 9) };
    [era * 400 + year, month, day]
}

/// A zone, as it stands after a time: +02:00.
pub(crate) fn zone_name(minutes: i32) -> String {
    let sign = if minutes < 0 { '-' } else { '+' };
    format!("{sign}{:02}:{:02}", minutes.abs() / 60, minutes.abs() % 60)
}

impl fmt::Display for Moment {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let from_midnight = self.clock + NOON;
        let [year, month, day] = date(from_midnight.div_euclid(DAY) + TO_2000);
        let second = from_midnight.rem_euclid(DAY);
        let (hour, minute, second) = (second / 3600, second / 60 % 60, second % 60);
        write!(f, "{year:04}-{month:02}-{day:02}T{hour:02}:{minute:02}:{second:02}")?;
        self.zone.map_or(Ok(()), |minutes| f.write_str(&zone_name(minutes)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_is_counted_from_noon_of_2000() {
        let moment = |date, time, zone| Moment::new(date, time, zone).unwrap();
        assert_eq!(moment([2000, 1, 1], [12, 0, 0], None), Moment { clock: 0, zone: None });
        let summer = moment([2014, 5, 26], [12, 45, 30], Some(120));
        assert_eq!(summer.utc(), moment([2014, 5, 26], [10, 45, 30], Some(0)).utc());
        // By POSIX's count, 946,728,000 seconds later.
        assert_eq!(summer.utc(), Some(1_401_101_130 - 946_728_000));
        assert_eq!(moment([1999, 12, 31], [23, 59, 60], None).clock, -NOON);
        assert_eq!(summer.to_string(), "2014-05-26T12:45:30+02:00");
        assert_eq!(summer.in_zone(-210).to_string(), "2014-05-26T12:45:30-03:30");
        assert_eq!(moment([1962, 2, 28], [0, 0, 1], None).to_string(), "1962-02-28T00:00:01");
    }

    #[test]
    fn what_no_calendar_has_is_no_moment() {
        for (date, is_one) in
            [([2000, 2, 29], true), ([1900, 2, 29], false), ([2023, 2, 29], false), ([2023, 0, 1], false)]
        {
            assert_eq!(Moment::new(date, [0; 3], None).is_some(), is_one, "{date:?}");
        }
        for date in [[2023, 13, 1], [2023, 4, 31], [2023, 1, 0], [0, 1, 1], [70_000, 1, 1]] {
            assert_eq!(Moment::new(date, [0; 3], None), None, "{date:?}");
        }
        for time in [[24, 0, 0], [0, 60, 0], [0, 0, 61], [-1, 0, 0]] {
            assert_eq!(Moment::new([2023, 1, 1], time, None), None, "{time:?}");
        }
        assert_eq!(Moment::new([2023, 1, 1], [0; 3], Some(1440)), None);
        assert!((-800_000..800_000).step_by(97).all(|day| days(date(day)) == day));
    }
}
