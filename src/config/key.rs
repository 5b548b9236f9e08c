//! A section's keys as their owner declares them: what the reader, the template and the tests all go by.

/// A key of a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Key {
    /// The key's name.
    pub name: &'static str,
    /// What the key means, in one line of any length.
    pub doc: &'static str,
    /// The key's default, or an example of its value.
    pub value: Value,
}

/// What a key holds where the file does not say. Texts are TOML.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Value {
    /// This default. It stands nowhere else.
    Default(&'static str),
    /// Nothing: the key must be given, as in this example.
    Needed(&'static str),
    /// Nothing: the key may be left out, or be given as in this example.
    Optional(&'static str),
    /// A section of its own, `SECTION.KEY`.
    Section,
}

/// A key that was once in a section.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Former {
    /// The key's name.
    pub name: &'static str,
    /// What became of the key.
    pub now: Now,
}

/// What became of a key.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Now {
    /// The key moved: `[infer] min_bins`.
    Moved(&'static str),
    /// The key is gone; the words say what holds without it.
    Gone(&'static str),
}

/// A section without its type.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Outline {
    /// The section's name, with the name of the section around it: `scene.poses`.
    pub name: &'static str,
    /// What the section is about, in one sentence.
    pub about: &'static str,
    /// The section's keys, in the order of the template.
    pub keys: &'static [Key],
    /// Keys that the section had once.
    pub former: &'static [Former],
}

impl Outline {
    /// The key of this name.
    pub fn key(&self, name: &str) -> Option<&'static Key> {
        self.keys.iter().find(|key| key.name == name)
    }

    /// The names of the keys.
    pub fn names(&self) -> Vec<&'static str> {
        self.keys.iter().map(|key| key.name).collect()
    }
}
