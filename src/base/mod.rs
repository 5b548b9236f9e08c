//! What every floor stands on: errors, ids, sets of them, units, content keys, arrays, the process's memory.

pub mod array;
mod bits;
pub mod error;
pub mod ids;
pub mod key;
pub mod memory;
pub mod units;

pub use array::Array;
pub use bits::Bits;
pub use error::{Error, Result};
