//! What a unit of work is made of: everything that the bytes of its files depend on, each by a name that a user knows. A
//! unit's name is the hash of its recipe, so that equal recipes are one unit, and two recipes can be compared part by part
//! to say why a unit has to be done again.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use crate::base::key::KeyBuilder;

/// A unit of work, by what it is and what it is made of.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    what: String,
    made_of: BTreeMap<String, String>,
}

impl Recipe {
    /// A unit that is made of nothing yet. The first word of `what` is its kind: "shard 17" is a shard.
    pub fn new(what: impl Into<String>) -> Self {
        Recipe { what: what.into(), made_of: BTreeMap::new() }
    }

    /// Adds a part: for an input the key of its content, for a setting its value; never a time or a path.
    #[must_use]
    pub fn with(mut self, part: impl Into<String>, value: impl ToString) -> Self {
        self.made_of.insert(part.into(), value.to_string());
        self
    }

    /// What it is.
    pub fn what(&self) -> &str {
        &self.what
    }

    /// What it is one of.
    pub fn kind(&self) -> &str {
        self.what.split(' ').next().unwrap_or_default()
    }

    /// Its parts, sorted by name.
    pub fn parts(&self) -> impl Iterator<Item = (&str, &str)> {
        self.made_of.iter().map(|(part, value)| (part.as_str(), value.as_str()))
    }

    /// The value of a part.
    pub fn part(&self, name: &str) -> Option<&str> {
        self.made_of.get(name).map(String::as_str)
    }

    /// The unit's name in the manifest, and the stem of its files' names: its kind and the hash of all of the above.
    pub fn unit(&self) -> String {
        let start = KeyBuilder::new("gonio unit 2").field(self.what.as_bytes());
        let all = self.parts().fold(start, |key, (part, value)| key.field(part.as_bytes()).field(value.as_bytes()));
        format!("{}-{}", self.kind(), all.finish())
    }

    /// Where this one differs from another, part by part: the name, the other's value, this one's.
    pub fn differences<'a>(&'a self, other: &'a Recipe) -> Vec<(&'a str, Option<&'a str>, Option<&'a str>)> {
        let mut names: Vec<&str> = self.parts().chain(other.parts()).map(|(part, _)| part).collect();
        names.sort_unstable();
        names.dedup();
        let both = names.into_iter().map(|name| (name, other.part(name), self.part(name)));
        both.filter(|(_, before, now)| before != now).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn equal_recipes_are_one_unit_in_whatever_order_they_are_written() {
        let one = Recipe::new("shard 7").with("a", 1).with("b", "x");
        assert_eq!(one.unit(), Recipe::new("shard 7").with("b", "x").with("a", "1").unit());
        assert!(one.unit().starts_with("shard-") && one.kind() == "shard");
        for other in [
            Recipe::new("shard 8").with("a", 1).with("b", "x"),
            Recipe::new("shard 7").with("a", 1),
            Recipe::new("shard 7").with("a", "1b").with("", "x"),
            Recipe::new("shard 7").with("a", 2).with("b", "x"),
        ] {
            assert_ne!(one.unit(), other.unit());
        }
    }

    #[test]
    fn differences_are_named_with_both_values() {
        let now = Recipe::new("a").with("same", 1).with("changed", 2).with("new", 3);
        let before = Recipe::new("a").with("same", 1).with("changed", 1).with("gone", 4);
        let expected = [("changed", Some("1"), Some("2")), ("gone", Some("4"), None), ("new", None, Some("3"))];
        assert_eq!(now.differences(&before), expected);
        assert!(now.differences(&now).is_empty());
    }
}
