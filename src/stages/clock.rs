//! Moments and places as a pipeline file has them.

use toml::value::{Datetime, Offset};

use crate::config::raw::{Node, Toml};
use crate::config::{FromToml, Problem};
use crate::scene::moment::Moment;

/// What a moment must be.
const RULE: &str = "must be a date and a time, 1950 to 2100, as \"2014-05-26T12:45:30+02:00\", or without the zone";

impl FromToml for Moment {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        // TOML has dates of its own, which need no quotes.
        let text = if let Toml::Date(date) = &node.value { Some(date.as_str()) } else { node.text() };
        text.and_then(moment).ok_or_else(|| RULE.into())
    }
}

/// The moment of RFC 3339's text.
fn moment(text: &str) -> Option<Moment> {
    let Datetime { date, time, offset } = text.trim().parse().ok()?;
    let (date, time) = (date?, time?);
    let zone = offset.map(|offset| match offset {
        Offset::Z => 0,
        Offset::Custom { minutes } => i32::from(minutes),
    });
    let date = [date.year.into(), date.month.into(), date.day.into()];
    let time = [time.hour.into(), time.minute.into(), time.second.unwrap_or(0).into()];
    // The formulas of the sun hold for so long.
    Moment::new(date, time, zone).filter(|_| (1950..=2100).contains(&date[0]))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_moment_has_a_date_a_time_and_perhaps_a_zone() {
        let summer = |zone| Moment::new([2014, 5, 26], [12, 45, 30], zone);
        for (text, wanted) in [
            ("2014-05-26T12:45:30+02:00", summer(Some(120))),
            ("2014-05-26 12:45:30.75-03:30", summer(Some(-210))),
            ("2014-05-26T12:45:30Z", summer(Some(0))),
            (" 2014-05-26T12:45:30 ", summer(None)),
            ("2014-05-26", None),
            ("12:45:30", None),
            ("2014-02-30T12:45:30", None),
            ("1949-05-26T12:45:30", None),
            ("noon", None),
            ("", None),
        ] {
            assert_eq!(moment(text), wanted, "{text:?}");
        }
    }
}
