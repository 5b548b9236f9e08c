//! Gather: the observations of a group of frames become one segment on disk.

use serde::Serialize;

use super::{Choice, Fault};

/// Section `[gather]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// What is done with observations that lie in a cast shadow.
    pub shadow: Shadow,
    /// Frames a segment, 1 to 1,024: what a resume may have to redo, and what is held in memory before it is written.
    pub group: u32,
}

/// What is done with observations that lie in a cast shadow.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Shadow {
    /// They are kept like all others.
    Keep,
}

impl Choice for Shadow {
    const NAMES: &'static [(&'static str, Self)] = &[("keep", Shadow::Keep)];
}

impl Default for Config {
    fn default() -> Self {
        Config { shadow: Shadow::Keep, group: 8 }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        Fault::unless_within("group", self.group, 1..=1024).into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_are_bounded() {
        for (group, faults) in [(0, 1), (1, 0), (1024, 0), (1025, 1)] {
            assert_eq!(Config { group, ..Config::default() }.check().len(), faults, "{group}");
        }
    }
}
