//! What a key may hold: numbers, truth values, texts, lists of numbers.

use std::fmt::Display;
use std::ops::RangeInclusive;

use super::problem::Problem;
use super::raw::{Node, Toml};
use crate::base::convert::to_f32;

/// A type that is read from a TOML value.
pub trait FromToml: Sized {
    /// Reads a value.
    ///
    /// # Errors
    /// What is allowed instead.
    fn from_toml(node: &Node) -> Result<Self, Problem>;
}

macro_rules! whole_numbers {
    ($($number:ty)*) => { $(
        impl FromToml for $number {
            fn from_toml(node: &Node) -> Result<Self, Problem> {
                let Toml::Integer(n) = node.value else { return Err("must be a whole number".into()) };
                Self::try_from(n).map_err(|_| if n < 0 { "must not be negative" } else { "is too large" }.into())
            }
        }
    )* };
}

whole_numbers!(u8 u32 u64 usize);

impl FromToml for f64 {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        match node.value {
            Toml::Float(x) => Ok(x),
            Toml::Integer(n) => Ok(n as f64),
            _ => Err(Problem::new("must be a number").got(node.value.describe())),
        }
    }
}

impl FromToml for f32 {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        f64::from_toml(node).map(to_f32)
    }
}

impl FromToml for bool {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        if let Toml::Bool(b) = node.value { Ok(b) } else { Err("must be true or false".into()) }
    }
}

impl FromToml for String {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        node.text().map(str::to_owned).ok_or_else(|| "must be a string".into())
    }
}

impl<T: FromToml, const N: usize> FromToml for [T; N] {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        let wrong = || Problem::new(format!("must be a list of {N} numbers"));
        let Toml::List(list) = &node.value else { return Err(wrong()) };
        let items: Vec<T> = list.iter().map(T::from_toml).collect::<Result<_, _>>()?;
        items.try_into().map_err(|_| wrong())
    }
}

impl<T: FromToml> FromToml for Vec<T> {
    fn from_toml(node: &Node) -> Result<Self, Problem> {
        let Toml::List(list) = &node.value else {
            return Err(Problem::new("must be a list").got(node.value.describe()));
        };
        list.iter().map(T::from_toml).collect()
    }
}

/// What is wrong with a value that lies outside of its range.
pub(crate) fn outside<T: PartialOrd + Display>(range: &RangeInclusive<T>, value: &T) -> Option<Problem> {
    let rule = || format!("must lie in {} to {}", range.start(), range.end());
    (!range.contains(value)).then(|| Problem::new(rule()).got(value.to_string()))
}
