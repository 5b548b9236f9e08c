//! `gonio explain`: what the next run would do again, as a table.

use super::report::Lines;
use crate::pipeline::explain::{Explanation, Part};

/// Causes that are listed of one kind of work.
const LISTED: usize = 20;

/// The explanation as lines of text.
pub fn table(explanation: &Explanation) -> String {
    if explanation.is_nothing() {
        return "nothing is done again: all is there".to_owned();
    }
    let mut lines = Lines::default();
    for part in &explanation.parts {
        lines.row(part.name, count(part));
        part.causes.iter().take(LISTED).for_each(|cause| lines.add(format!("  {cause}")));
        if part.causes.len() > LISTED {
            lines.add(format!("  and {} more", part.causes.len() - LISTED));
        }
    }
    lines.finish()
}

fn count(Part { total, again, at_least, .. }: &Part) -> String {
    match (total, again, at_least) {
        (0, 0, true) => "not known before the frames are cast".to_owned(),
        (0, again, true) => format!("at least {again}"),
        (_, 0, _) => "none".to_owned(),
        (total, again, _) => format!("{again} of {total}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_kind_of_work_is_told_with_its_causes() {
        let part = |name, total, again, at_least, causes: &[&str]| Part {
            name,
            total,
            again,
            at_least,
            causes: causes.iter().map(|&cause| cause.to_owned()).collect(),
        };
        let explanation = Explanation {
            parts: vec![
                part("frames", 10, 2, false, &["the image of a.jpg changed"]),
                part("shards", 0, 0, true, &["all that the frames above see"]),
                part("tables", 1, 1, false, &["made of what is done again above"]),
                part("exports", 2, 0, false, &[]),
            ],
        };
        insta::assert_snapshot!(table(&explanation), @r"
        frames         2 of 10
          the image of a.jpg changed
        shards         not known before the frames are cast
          all that the frames above see
        tables         1 of 1
          made of what is done again above
        exports        none
        ");
        assert_eq!(table(&Explanation::default()), "nothing is done again: all is there");
    }
}
