//! What is wrong with a pipeline file, as a list: all of it at once, each with its place.

use std::fmt;
use std::path::PathBuf;

/// Where something stands. Places of the file come first, in its order.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Place {
    /// Nowhere: what ought to be there is not.
    Whole,
    /// In the file, both counted from 1, the column in characters.
    File {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
    },
    /// On the command line, after `--set`.
    Set,
}

/// One thing that is wrong.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Problem {
    /// Where.
    pub place: Place,
    /// Which key, with its section: `cast.tile`. Empty where there is none.
    pub field: String,
    /// What is allowed.
    pub rule: String,
    /// What was found, if anything was.
    pub got: Option<String>,
    /// What to do, where there is more to say than the rule does.
    pub hint: Option<String>,
}

impl Problem {
    /// A problem that has only a place, a key and a rule.
    pub fn new(place: Place, field: impl Into<String>, rule: impl Into<String>) -> Self {
        Problem { place, field: field.into(), rule: rule.into(), got: None, hint: None }
    }

    /// The same, with what was found.
    #[must_use]
    pub fn got(mut self, got: impl Into<String>) -> Self {
        self.got = Some(got.into());
        self
    }

    /// The same, with what to do.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }
}

/// Everything that is wrong with one file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problems {
    /// The file, as it was named.
    pub file: PathBuf,
    /// The problems, sorted by place.
    pub list: Vec<Problem>,
}

/// Problems shown before the rest is only counted; a file may hold anything.
const SHOWN: usize = 50;

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, problem) in self.list.iter().take(SHOWN).enumerate() {
            if at > 0 {
                writeln!(f)?;
            }
            let Problem { place, field, rule, got, hint } = problem;
            match place {
                Place::Whole => write!(f, "{}: ", self.file.display())?,
                Place::File { line, column } => write!(f, "{}:{line}:{column}: ", self.file.display())?,
                Place::Set => f.write_str("--set ")?,
            }
            if !field.is_empty() {
                write!(f, "{}: ", field.escape_debug())?;
            }
            f.write_str(rule)?;
            if let Some(got) = got {
                write!(f, "; got {got}")?;
            }
            if let Some(hint) = hint {
                write!(f, "; {hint}")?;
            }
        }
        match self.list.len().saturating_sub(SHOWN) {
            0 => Ok(()),
            more => write!(f, "\n{}: and {more} more", self.file.display()),
        }
    }
}

impl std::error::Error for Problems {}

/// Words for an unknown name: the known ones, and the one that may have been meant.
pub fn unknown(name: &str, known: &[&str]) -> (String, Option<String>) {
    let near = known.iter().map(|k| (strsim::damerau_levenshtein(&cut(name), k), k)).min();
    // A third of the letters wrong is still a typo; more is another word.
    let meant = near.filter(|(distance, k)| 3 * distance <= k.len().max(3));
    (format!("the known ones are {}", known.join(", ")), meant.map(|(_, k)| format!("did you mean `{k}`?")))
}

/// Text of a stranger, fit to be shown: short, and without control characters.
pub fn shown(text: &str) -> String {
    let short = cut(text);
    let dots = if short.len() < text.len() { "..." } else { "" };
    format!("\"{}{dots}\"", short.escape_debug())
}

fn cut(text: &str) -> String {
    text.chars().take(100).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_typo_is_guessed_and_another_word_is_not() {
        let known = ["tile", "transfer", "formats"];
        for (name, meant) in [
            ("tiel", Some("tile")),
            ("tiles", Some("tile")),
            ("format", Some("formats")),
            ("trasnfr", Some("transfer")),
            ("x", None),
            ("", None),
            ("exposure", None),
        ] {
            assert_eq!(unknown(name, &known).1, meant.map(|m| format!("did you mean `{m}`?")), "{name}");
        }
    }

    #[test]
    fn what_strangers_wrote_cannot_write_on_the_terminal() {
        assert_eq!(shown("a\u{1b}[2J\n"), r#""a\u{1b}[2J\n""#);
        assert!(shown(&"x".repeat(1 << 20)).len() < 200);
    }

    #[test]
    fn a_flood_is_counted_and_not_shown() {
        let list = vec![Problem::new(Place::Whole, "a", "is wrong"); 60];
        let text = Problems { file: "p.toml".into(), list }.to_string();
        assert_eq!(text.lines().count(), 51);
        assert!(text.ends_with("p.toml: and 10 more"));
    }
}
