//! The units of a phase: the pieces of work that commit one by one.

use crate::disk::{Recipe, UnitName};

/// A piece of work that commits alone.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Unit {
    /// The unit's name, which is the hash of its recipe.
    pub name: UnitName,
    /// All that the unit's bytes depend on.
    pub recipe: Recipe,
    /// How many of the things that the phase counts are in the unit: the frames of a group.
    pub weight: u64,
}

impl Unit {
    /// A unit that counts for one.
    pub(crate) fn new(recipe: Recipe) -> Self {
        Unit { name: recipe.unit(), recipe, weight: 1 }
    }

    /// The same unit, counting for `weight`.
    #[must_use]
    pub(crate) fn weighing(self, weight: u64) -> Self {
        Unit { weight, ..self }
    }
}

/// How much is known of a phase's units.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Extent {
    /// The units are these.
    Exact,
    /// The units are these and maybe more: the phases before are not done yet.
    AtLeast,
    /// There are as many units as these, with other recipes: what they are made of is done over.
    Renewed,
    /// The phase keeps no units: it does its work in every run.
    #[default]
    Unkept,
    /// The phase has nothing to do in this pipeline.
    Absent,
}

/// The units of a phase, as far as they are known.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Units {
    /// The plural noun for what the phase counts: "frames".
    pub noun: &'static str,
    /// The units.
    pub all: Vec<Unit>,
    /// How much is known of the units.
    pub extent: Extent,
}

impl Units {
    /// The units of a phase that keeps none.
    pub(crate) fn unkept() -> Self {
        Units::default()
    }

    /// The units of a phase that has nothing to do.
    pub(crate) fn absent() -> Self {
        Units { extent: Extent::Absent, ..Units::default() }
    }
}
