//! What every floor stands on: errors, ids, units, content keys.

pub mod error;
pub mod ids;
pub mod key;
pub mod units;

pub use error::{Error, Result};
