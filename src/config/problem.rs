//! What is wrong with a file: a list of all problems at once, each with its position.

use std::fmt;
use std::path::PathBuf;

use crate::base::shown::cut;

/// The position of something in what was given. Positions in the file come first, in its order.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub enum Position {
    /// The whole file: what ought to be there is not.
    Whole,
    /// In the file, both counted from 1, the column in characters.
    File {
        /// The line.
        line: usize,
        /// The column.
        column: usize,
    },
    /// The command line, after `--set`.
    Set,
}

/// One thing that is wrong with a file.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord)]
pub struct Problem {
    /// The problem's position.
    pub position: Position,
    /// The key, with its section: `cast.tile`. Empty where there is none.
    pub field: String,
    /// What is allowed.
    pub rule: String,
    /// What was found, if anything was.
    pub got: Option<String>,
    /// What to do, where the rule does not say it.
    pub hint: Option<String>,
}

impl Problem {
    /// A problem with this rule, of no key yet.
    pub fn new(rule: impl Into<String>) -> Self {
        Problem { position: Position::Whole, field: String::new(), rule: rule.into(), got: None, hint: None }
    }

    /// The problem with its position and its key.
    #[must_use]
    pub fn at(self, position: Position, field: impl Into<String>) -> Self {
        Problem { position, field: field.into(), ..self }
    }

    /// The problem with what was found.
    #[must_use]
    pub fn got(self, got: impl Into<String>) -> Self {
        Problem { got: Some(got.into()), ..self }
    }

    /// The problem with what to do.
    #[must_use]
    pub fn hint(self, hint: impl Into<String>) -> Self {
        Problem { hint: Some(hint.into()), ..self }
    }
}

impl From<&str> for Problem {
    fn from(rule: &str) -> Self {
        Problem::new(rule)
    }
}

impl From<String> for Problem {
    fn from(rule: String) -> Self {
        Problem::new(rule)
    }
}

/// What is wrong with a file.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Problems {
    /// The file's path, as it was given.
    pub file: PathBuf,
    /// The first problems, at most 50, sorted by position.
    pub list: Vec<Problem>,
    /// The number of problems beside those.
    pub more: usize,
}

/// Problems of a file that are told; the rest is counted.
pub(super) const TOLD: usize = 50;

impl fmt::Display for Problems {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for (at, problem) in self.list.iter().enumerate() {
            if at > 0 {
                writeln!(f)?;
            }
            let Problem { position, field, rule, got, hint } = problem;
            match position {
                Position::Whole => write!(f, "{}: ", self.file.display())?,
                Position::File { line, column } => write!(f, "{}:{line}:{column}: ", self.file.display())?,
                Position::Set => f.write_str("--set ")?,
            }
            if !field.is_empty() {
                let (short, dots) = (cut(field), if cut(field).len() < field.len() { "..." } else { "" });
                write!(f, "{}{dots}: ", short.escape_debug())?;
            }
            f.write_str(rule)?;
            if let Some(got) = got {
                write!(f, "; got {got}")?;
            }
            if let Some(hint) = hint {
                write!(f, "; {hint}")?;
            }
        }
        match self.more {
            0 => Ok(()),
            more => write!(f, "\n{}: and {more} more", self.file.display()),
        }
    }
}

impl std::error::Error for Problems {}

/// What to say of an unknown name: the known names, and the name that may have been meant.
pub(crate) fn unknown(name: &str, known: &[&str]) -> (String, Option<String>) {
    let near = known.iter().map(|k| (strsim::damerau_levenshtein(cut(name), k), k)).min();
    // A third of the letters wrong is still a typo; more is another word.
    let meant = near.filter(|(distance, k)| 3 * distance <= k.len().max(3));
    (format!("the known ones are {}", known.join(", ")), meant.map(|(_, k)| format!("did you mean `{k}`?")))
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
    fn a_flood_is_counted_and_not_shown() {
        let list = vec![Problem::new("is wrong").at(Position::Whole, "a".repeat(1 << 18)); TOLD];
        let text = Problems { file: "p.toml".into(), list, more: 10 }.to_string();
        assert_eq!(text.lines().count(), 51);
        assert!(text.ends_with("p.toml: and 10 more") && text.len() < 200 * TOLD, "{}", text.len());
    }
}
