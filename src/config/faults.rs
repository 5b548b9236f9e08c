//! The problems of one file while they are found: those that may be told in words, all others as a number. However many there
//! are, few are put into words.

use std::path::Path;

use super::problem::{Problem, Problems, TOLD};

/// The problems found so far.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Faults {
    found: Vec<Problem>,
    more: usize,
}

impl Faults {
    /// Adds a problem.
    pub fn add(&mut self, problem: Problem) {
        self.found.push(problem);
    }

    /// Adds as many problems as there are keys, in the order of the keys. `words` is asked only for those that may be told.
    pub fn add_many<K: Ord, T>(&mut self, mut all: Vec<(K, T)>, words: impl Fn((K, T)) -> Problem) {
        all.sort_by(|a, b| a.0.cmp(&b.0));
        self.more += all.len().saturating_sub(TOLD);
        self.found.extend(all.into_iter().take(TOLD).map(words));
    }

    /// Whether nothing is wrong.
    pub fn is_empty(&self) -> bool {
        self.found.is_empty()
    }

    /// The first problems, as those of a file, and the number of the others.
    pub fn of_file(mut self, file: &Path) -> Problems {
        self.found.sort();
        self.more += self.found.len().saturating_sub(TOLD);
        self.found.truncate(TOLD);
        Problems { file: file.to_owned(), list: self.found, more: self.more }
    }
}

impl From<Problem> for Faults {
    fn from(problem: Problem) -> Self {
        Faults { found: vec![problem], more: 0 }
    }
}

#[cfg(test)]
mod tests {
    use std::cell::Cell;

    use super::super::problem::Position;
    use super::*;

    #[test]
    fn the_first_are_told_wherever_they_were_found() {
        let (asked, mut faults) = (Cell::new(0), Faults::default());
        let line = |line| Position::File { line, column: 1 };
        for half in [0, 1] {
            let all = (0..1000).rev().map(|n| (2 * n + half, ())).collect();
            faults.add_many(all, |(n, ())| {
                asked.set(asked.get() + 1);
                Problem::new(n.to_string()).at(line(n), "")
            });
        }
        faults.add(Problem::new("first"));
        let Problems { list, more, .. } = faults.of_file(Path::new("p.toml"));
        assert_eq!((list.len(), more, asked.get()), (TOLD, 2001 - TOLD, 2 * TOLD));
        assert_eq!((list[0].rule.as_str(), list[TOLD - 1].rule.as_str()), ("first", "48"));
    }
}
