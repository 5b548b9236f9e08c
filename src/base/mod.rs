//! The ground floor: errors, ids, sets of triangles, conversions between numbers, units, content keys, arrays, input
//! files, texts and calls of others, the names of the phases, and the memory of the process.

pub(crate) mod array;
mod bits;
pub(crate) mod convert;
pub(crate) mod error;
#[cfg(test)]
pub(crate) mod faulty_input;
pub(crate) mod guard;
pub(crate) mod ids;
pub(crate) mod input;
pub(crate) mod key;
pub(crate) mod memory;
pub(crate) mod paths;
pub(crate) mod patience;
pub(crate) mod pattern;
pub(crate) mod phase;
pub(crate) mod shown;
pub(crate) mod units;

pub(crate) use array::Array;
pub(crate) use bits::Bits;
pub use error::{Error, Result};
pub use phase::PhaseName;
