//! Settings: every key's value, and what depends on it.

use std::fmt::Debug;

/// What has to be done over when a setting changes.
#[derive(Debug, Clone, Copy, PartialEq, Eq, PartialOrd, Ord)]
pub enum Effect {
    /// Nothing: the setting changes how fast a run is, how much it holds, or where it writes.
    Nothing,
    /// What is made of the input that the setting names, if the input's content is another.
    Input,
    /// Finding exposures and light, and what is made of those that change.
    Look,
    /// Casting, and all that follows.
    Cast,
    /// Inference, and all that follows.
    Infer,
    /// Inference, where the estimator is told the light, and all that follows.
    Light,
    /// The tables, and all that follows.
    Merge,
    /// The exports, which say where on the earth the mesh lies.
    Place,
    /// The exports that turn the mesh to axes of their own.
    Axes,
    /// The exports that were not there.
    Formats,
}

/// A key's value and one of its effects.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Setting {
    /// The key with its section: `decode.transfer`.
    pub key: String,
    /// The value, as it may stand in a file; `none` where there is none.
    pub value: String,
    /// What depends on it.
    pub effect: Effect,
}

/// The settings of a section. A key with two effects is listed twice.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Settings {
    section: &'static str,
    list: Vec<Setting>,
}

impl Settings {
    /// No settings yet, of the section of this name.
    pub(crate) fn of(section: &'static str) -> Self {
        Settings { section, list: Vec::new() }
    }

    /// Adds a setting.
    #[must_use]
    pub(crate) fn with(mut self, key: &str, value: impl Debug, effect: Effect) -> Self {
        self.list.push(Setting { key: format!("{}.{key}", self.section), value: format!("{value:?}"), effect });
        self
    }

    /// Adds a setting that may be missing.
    #[must_use]
    pub(crate) fn optional(mut self, key: &str, value: Option<impl Debug>, effect: Effect) -> Self {
        let value = value.map_or_else(|| "none".to_owned(), |value| format!("{value:?}"));
        self.list.push(Setting { key: format!("{}.{key}", self.section), value, effect });
        self
    }

    /// Adds the settings of a section within this one.
    #[must_use]
    pub(crate) fn and(mut self, section: Settings) -> Self {
        self.list.extend(section.list);
        self
    }
}

impl IntoIterator for Settings {
    type Item = Setting;
    type IntoIter = std::vec::IntoIter<Setting>;

    fn into_iter(self) -> Self::IntoIter {
        self.list.into_iter()
    }
}
