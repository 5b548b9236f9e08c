//! A section: whoever owns a key owns its documentation, default, reading, check and effect.

use std::path::Path;

use super::document::Document;
use super::faults::Faults;
use super::key::{Former, Key, Outline};
use super::keys::Keys;
use super::problem::{Position, Problem};
use super::raw::{Node, Table, Toml};
use super::setting::Settings;

/// A section of a pipeline file, read and checked.
pub(crate) trait Section: Sized {
    /// The section's name: `cast`, `scene.poses`.
    const NAME: &'static str;
    /// What the section is about, in one sentence.
    const ABOUT: &'static str;
    /// The section's keys, in the order of the template.
    const KEYS: &'static [Key];
    /// Keys that the section had once.
    const FORMER: &'static [Former] = &[];
    /// All of the above.
    const OUTLINE: Outline = Outline { name: Self::NAME, about: Self::ABOUT, keys: Self::KEYS, former: Self::FORMER };

    /// Reads and checks the section. What is wrong becomes problems of `keys`.
    fn read(keys: &Keys<'_>) -> Self;

    /// Every key's value and effect. Destructures `self` without `..`, so that a new key does not compile until its effect
    /// is decided.
    fn settings(&self) -> Settings;
}

/// A section with the defaults of all its keys; a key that must be given is empty.
pub(crate) fn defaults<S: Section>() -> S {
    of_table(Table::new()).0
}

/// Reads a section from the text within it, as in `tile = 33`. Paths are relative to the current folder.
#[cfg(test)]
pub(crate) fn read_text<S: Section>(text: &str) -> (S, Vec<Problem>) {
    match super::raw::parse(text) {
        Ok(table) => of_table(table),
        Err(faults) => (defaults(), faults.of_file(Path::new("")).list),
    }
}

fn of_table<S: Section>(table: Table) -> (S, Vec<Problem>) {
    let found = (Position::Whole, Node { position: Position::Whole, value: Toml::Table(table), bare: None });
    let root = Table::new();
    let document = Document::new(&root, Path::new(""), Faults::default());
    let section = S::read(&Keys::open(&document, S::OUTLINE, Some(&found)));
    (section, document.into_faults().of_file(Path::new("")).list)
}
