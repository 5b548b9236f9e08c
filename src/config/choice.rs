//! Options that are chosen by name.

use super::problem::{Problem, unknown};
use super::raw::Node;
use crate::base::shown::shown;

/// An option that is chosen by name.
pub trait Choice: Copy + PartialEq + 'static {
    /// Every choice and its name in a pipeline file; at least one.
    const NAMES: &'static [(&'static str, Self)];

    /// The choice of this name.
    fn named(name: &str) -> Option<Self> {
        Self::NAMES.iter().find(|(n, _)| *n == name).map(|(_, choice)| *choice)
    }

    /// The choice's name.
    fn name(self) -> &'static str {
        Self::NAMES.iter().find(|(_, choice)| *choice == self).map_or("", |(n, _)| n)
    }
}

/// Reads the name of one of these.
pub(super) fn choose<T: Copy>(node: &Node, among: &[(&'static str, T)]) -> Result<T, Problem> {
    let no_name = || Problem::new(format!("must be a name: {}", names(among))).got(node.value.describe());
    let name = node.text().ok_or_else(no_name)?;
    among.iter().find(|(known, _)| *known == name).map(|(_, choice)| *choice).ok_or_else(|| {
        let known: Vec<&str> = among.iter().map(|(name, _)| *name).collect();
        Problem { hint: unknown(name, &known).1, ..Problem::new(format!("must be {}", names(among))) }.got(shown(name))
    })
}

/// The names of all of these, for a message.
pub(super) fn names<T>(among: &[(&'static str, T)]) -> String {
    let names: Vec<String> = among.iter().map(|(name, _)| format!("\"{name}\"")).collect();
    names.join(" or ")
}
