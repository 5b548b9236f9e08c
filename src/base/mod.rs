//! What every floor stands on: errors, ids, units, content keys, arrays, the process's memory.

pub mod array;
pub mod error;
pub mod ids;
pub mod key;
pub mod memory;
pub mod units;

pub use array::Array;
pub use error::{Error, Result};
