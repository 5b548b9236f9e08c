//! How a file of sections and keys is read, checked and documented. Nothing here knows what a section means.
//!
//! A [`Section`] owns its keys: a name, a line of documentation and a default each ([`Key`]). It reads itself through
//! [`Keys`], which turn every value that cannot be used into a [`Problem`] with its line and column and go on with the
//! default, so that one reading finds all problems. It tells for every setting what has to be done over when the setting
//! changes ([`Effect`]).
//!
//! ```text
//! raw        the tree of a TOML file, every node with its position
//! place      the lines and columns of byte offsets
//! problem    what is wrong with a file
//! faults     the problems of a file while they are found
//! key        a section's keys as their owner declares them
//! document   one file being read: its tree and the problems so far
//! keys       the reader of one section; value, choice, path: what a key may hold
//! setting    a key's value and what depends on it
//! section    the trait
//! ```

mod choice;
mod document;
mod faults;
mod key;
mod keys;
mod path;
mod place;
mod problem;
pub(crate) mod raw;
mod section;
mod setting;
mod value;

pub(crate) use choice::Choice;
pub(crate) use document::Document;
pub(crate) use faults::Faults;
pub(crate) use key::{Former, Key, Now, Outline, Value};
pub(crate) use keys::Keys;
pub(crate) use path::{Leads, real};
pub(crate) use problem::unknown;
pub use problem::{Position, Problem, Problems};
#[cfg(test)]
pub(crate) use section::read_text;
pub(crate) use section::{Section, defaults};
pub(crate) use setting::{Effect, Setting, Settings};
pub(crate) use value::FromToml;
pub(crate) use value::outside;
