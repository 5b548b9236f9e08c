//! Recipes and names of units. A unit is a piece of work that commits alone; its recipe lists all that its bytes depend
//! on, each ingredient under a name that a user knows. The unit's name is the hash of the recipe: equal recipes are one
//! unit, and two recipes can be compared to say why a unit has to be done again.

use std::collections::BTreeMap;
use std::fmt;
use std::str::FromStr;

use serde::{Deserialize, Serialize};

use crate::base::PhaseName;
use crate::base::key::{Key, KeyBuilder};

/// All that a unit's bytes depend on.
#[derive(Debug, Clone, PartialEq, Eq, PartialOrd, Ord, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Recipe {
    phase: PhaseName,
    what: String,
    ingredients: BTreeMap<String, String>,
}

/// A unit's name: its phase and the hash of its recipe, written `cast-` and 64 digits in hex.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord, Hash)]
pub struct UnitName {
    phase: PhaseName,
    hash: [u8; 32],
}

/// An ingredient in which two recipes differ.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Difference<'a> {
    /// The ingredient's name.
    pub ingredient: &'a str,
    /// The ingredient's value in the earlier recipe, if it had one.
    pub before: Option<&'a str>,
    /// The ingredient's value in the later recipe, if it has one.
    pub now: Option<&'a str>,
}

impl Recipe {
    /// A recipe without ingredients. `what` tells the units of a phase apart, as `17` tells shards; it is empty where a
    /// phase has one unit.
    pub fn new(phase: PhaseName, what: impl Into<String>) -> Self {
        Recipe { phase, what: what.into(), ingredients: BTreeMap::new() }
    }

    /// Adds an ingredient: of an input the key of its content, of a setting its value; never a time or a path.
    #[must_use]
    pub fn with(mut self, ingredient: impl Into<String>, value: impl ToString) -> Self {
        self.ingredients.insert(ingredient.into(), value.to_string());
        self
    }

    /// Adds ingredients.
    #[must_use]
    pub fn with_all(mut self, ingredients: impl IntoIterator<Item = (String, String)>) -> Self {
        self.ingredients.extend(ingredients);
        self
    }

    /// Gives an ingredient this value, or takes it out.
    #[must_use]
    pub fn with_or_without(mut self, ingredient: impl Into<String>, value: Option<impl ToString>) -> Self {
        match value {
            Some(value) => self.ingredients.insert(ingredient.into(), value.to_string()),
            None => self.ingredients.remove(&ingredient.into()),
        };
        self
    }

    /// The phase that the unit belongs to.
    pub fn phase(&self) -> PhaseName {
        self.phase
    }

    /// Which unit of its phase this is.
    pub fn what(&self) -> &str {
        &self.what
    }

    /// The ingredients' names and values, sorted by name.
    pub fn ingredients(&self) -> impl Iterator<Item = (&str, &str)> {
        self.ingredients.iter().map(|(name, value)| (name.as_str(), value.as_str()))
    }

    /// The unit as people know it: its phase, and which unit of the phase it is, as "cast 17".
    pub fn in_words(&self) -> String {
        in_words(self.phase, &self.what)
    }

    /// The value of an ingredient.
    pub fn ingredient(&self, name: &str) -> Option<&str> {
        self.ingredients.get(name).map(String::as_str)
    }

    /// The unit's name.
    pub fn unit(&self) -> UnitName {
        name_of(self.phase, &self.what, &self.ingredients)
    }

    /// The ingredients in which this recipe differs from an earlier one, sorted by name.
    pub fn differences<'a>(&'a self, before: &'a Recipe) -> Vec<Difference<'a>> {
        let mut names: Vec<&str> = self.ingredients().chain(before.ingredients()).map(|(name, _)| name).collect();
        names.sort_unstable();
        names.dedup();
        let both = names.into_iter().map(|name| Difference {
            ingredient: name,
            before: before.ingredient(name),
            now: self.ingredient(name),
        });
        both.filter(|found| found.before != found.now).collect()
    }
}

/// The name of the unit with these parts of a recipe.
pub(super) fn name_of(phase: PhaseName, what: &str, ingredients: &BTreeMap<String, String>) -> UnitName {
    let start = KeyBuilder::new("gonio unit 3").field(phase.as_str().as_bytes()).field(what.as_bytes());
    let all = ingredients.iter().fold(start, |key, (name, value)| key.field(name.as_bytes()).field(value.as_bytes()));
    UnitName { phase, hash: all.finish().0 }
}

/// A unit as people know it, as "cast 17".
pub(super) fn in_words(phase: PhaseName, what: &str) -> String {
    if what.is_empty() { phase.to_string() } else { format!("{phase} {what}") }
}

impl UnitName {
    /// The phase that the unit belongs to.
    pub fn phase(&self) -> PhaseName {
        self.phase
    }

    /// The lowest and the highest name that a unit of a phase can have.
    pub(super) fn range(phase: PhaseName) -> std::ops::RangeInclusive<UnitName> {
        UnitName { phase, hash: [0; 32] }..=UnitName { phase, hash: [0xff; 32] }
    }
}

impl fmt::Display for UnitName {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}-{}", self.phase, Key(self.hash))
    }
}

impl FromStr for UnitName {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (phase, hash) = text
            .split_once('-')
            .ok_or_else(|| format!("{text:?} is not a unit's name: write the phase, a dash and 64 digits in hex"))?;
        Ok(UnitName { phase: phase.parse()?, hash: hash.parse::<Key>()?.0 })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn seven() -> Recipe {
        Recipe::new(PhaseName::Infer, "7").with("a", 1).with("b", "x")
    }

    #[test]
    fn equal_recipes_are_one_unit_in_whatever_order_they_are_written() {
        assert_eq!(seven().unit(), Recipe::new(PhaseName::Infer, "7").with("b", "x").with("a", "1").unit());
        let all = [("b", "x"), ("a", "1")].map(|(name, value)| (name.to_owned(), value.to_owned()));
        assert_eq!(seven(), Recipe::new(PhaseName::Infer, "7").with_all(all));
        for other in [
            Recipe::new(PhaseName::Infer, "8").with("a", 1).with("b", "x"),
            Recipe::new(PhaseName::Cast, "7").with("a", 1).with("b", "x"),
            Recipe::new(PhaseName::Infer, "7").with("a", 1),
            Recipe::new(PhaseName::Infer, "7").with("a", "1b").with("", "x"),
            seven().with("a", 2),
        ] {
            assert_ne!(seven().unit(), other.unit());
            assert_ne!(seven().unit().hash, other.unit().hash);
        }
    }

    #[test]
    fn what_is_put_in_is_told() {
        let recipe = seven();
        assert_eq!((recipe.phase(), recipe.what()), (PhaseName::Infer, "7"));
        assert_eq!(recipe.ingredients().collect::<Vec<_>>(), [("a", "1"), ("b", "x")]);
        assert_eq!((recipe.ingredient("b"), recipe.ingredient("c")), (Some("x"), None));
    }

    #[test]
    fn differences_are_named_with_both_values() {
        let new = || Recipe::new(PhaseName::Mock, "");
        let now = new().with("same", 1).with("changed", 2).with("new", 3);
        let before = new().with("same", 1).with("changed", 1).with("gone", 4);
        let expected = [("changed", Some("1"), Some("2")), ("gone", Some("4"), None), ("new", None, Some("3"))]
            .map(|(ingredient, before, now)| Difference { ingredient, before, now });
        assert_eq!(now.differences(&before), expected);
        assert!(now.differences(&now).is_empty());
    }

    #[test]
    fn a_name_is_small_and_read_as_it_is_written() {
        assert!((33..=40).contains(&size_of::<UnitName>()));
        let name = seven().unit();
        let text = name.to_string();
        assert_eq!((text.parse(), name.phase(), text.len()), (Ok(name), PhaseName::Infer, 6 + 64));
        for bad in ["", "infer", "infer-", &text[..69], &format!("{text}0"), &text.replace("infer", "bake"), &text[6..]]
        {
            assert!(bad.parse::<UnitName>().is_err(), "{bad}");
        }
        let range = UnitName::range(PhaseName::Infer);
        assert!(range.contains(&name) && !range.contains(&Recipe::new(PhaseName::Merge, "7").unit()));
    }
}
