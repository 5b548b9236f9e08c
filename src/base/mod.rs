//! The ground floor: errors, ids, sets of triangles, conversions between numbers, units, content keys, arrays, files and texts of others, the
//! names of the phases, and the memory of the process.

pub(crate) mod array;
mod bits;
pub(crate) mod convert;
pub(crate) mod error;
pub(crate) mod file;
pub(crate) mod ids;
pub(crate) mod key;
pub(crate) mod memory;
pub(crate) mod phase;
pub(crate) mod shown;
pub(crate) mod units;

pub(crate) use array::Array;
pub(crate) use bits::Bits;
pub use error::{Error, Result};
pub use phase::PhaseName;
