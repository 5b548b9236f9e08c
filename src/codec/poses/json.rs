//! JSON files, and the two ways in which they hold numbers.

use std::path::Path;

use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer};

use super::whole;
use crate::base::shown::{brief, shown};
use crate::base::{Error, Result};

/// Reads a JSON file. What the type does not ask for is passed over and not held.
///
/// # Errors
/// A file that cannot be read; what is no JSON, or not of the type, with line and column.
pub(super) fn read<T: DeserializeOwned>(path: &Path) -> Result<T> {
    serde_json::from_str(&whole::text(path)?).map_err(|why| Error::malformed(path, brief(&why)))
}

/// A finite number, written as a number or as a string of one.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Number(pub f64);

impl<'de> Deserialize<'de> for Number {
    fn deserialize<D: Deserializer<'de>>(from: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        #[serde(untagged)]
        enum Either {
            Number(f64),
            Text(String),
        }
        let value = match Either::deserialize(from).map_err(|_| D::Error::custom("a number is needed"))? {
            Either::Number(value) => value,
            Either::Text(text) => {
                let number = text.trim().parse();
                number.map_err(|_| D::Error::custom(format!("{} is no number", shown(&text))))?
            }
        };
        if value.is_finite() { Ok(Number(value)) } else { Err(D::Error::custom(format!("{value} is not finite"))) }
    }
}

/// The values of an array of numbers.
pub(super) fn values<const N: usize>(numbers: [Number; N]) -> [f64; N] {
    numbers.map(|number| number.0)
}
