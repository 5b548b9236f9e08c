//! The stages of a run. Each file is a stage: its configuration, the check of that configuration, the stage, its tests.
//!
//! A stage says what is wrong with its configuration by [`Fault`]s that name a key of its section; where that key
//! stands, and in which file, is `pipeline`'s to add.

pub mod cast;
pub mod decode;
pub mod export;
pub mod fill;
pub mod frames;
pub mod gather;
pub mod infer;
pub mod light;
pub mod merge;
pub mod shards;

use std::fmt::Display;
use std::ops::RangeInclusive;

/// What is wrong with one key of a stage's configuration.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Fault {
    /// The key, within the stage's section.
    pub key: &'static str,
    /// What is allowed.
    pub rule: String,
    /// What was found.
    pub got: String,
    /// What to do, where there is more to say than the rule does.
    pub hint: Option<String>,
}

impl Fault {
    /// A fault without a hint.
    pub fn new(key: &'static str, rule: impl Into<String>, got: impl Display) -> Self {
        Fault { key, rule: rule.into(), got: got.to_string(), hint: None }
    }

    /// The same fault with a hint.
    #[must_use]
    pub fn hint(mut self, hint: impl Into<String>) -> Self {
        self.hint = Some(hint.into());
        self
    }

    /// A fault if a value is out of its range.
    pub fn unless_within<T: PartialOrd + Display>(
        key: &'static str,
        value: T,
        range: RangeInclusive<T>,
    ) -> Option<Self> {
        let rule = || format!("must lie in {} to {}", range.start(), range.end());
        (!range.contains(&value)).then(|| Fault::new(key, rule(), value))
    }
}

/// An option that is chosen by name.
pub trait Choice: Copy + PartialEq + 'static {
    /// Every choice and its name in a pipeline file.
    const NAMES: &'static [(&'static str, Self)];

    /// The choice of this name.
    fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, choice)| *choice)
    }

    /// The name of this choice.
    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, choice)| *choice == self).map_or("", |(n, _)| n)
    }
}
