//! Decode: an image file becomes linear radiance on the pixel grid that its pose was solved on.

use serde::Serialize;

use super::{Choice, Fault};

/// Section `[decode]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// How stored values become linear radiance.
    pub transfer: Transfer,
    /// The exponent of [`Transfer::Gamma`], 0.2 to 5; none with any other transfer.
    pub gamma: Option<f64>,
    /// What is done about exposures that differ between frames.
    pub exposure: Exposure,
}

/// How stored values in [0, 1] become linear radiance. Floating-point files are linear and are never changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Transfer {
    /// The inverse of IEC 61966-2-1: what a camera's JPEG holds.
    Srgb,
    /// Stored values are linear.
    Linear,
    /// Stored values to the power of `gamma`.
    Gamma,
}

impl Choice for Transfer {
    const NAMES: &'static [(&'static str, Self)] =
        &[("srgb", Transfer::Srgb), ("linear", Transfer::Linear), ("gamma", Transfer::Gamma)];
}

/// What is done about exposures that differ between frames.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Exposure {
    /// Nothing: frames are taken to be exposed alike.
    AsIs,
}

impl Choice for Exposure {
    const NAMES: &'static [(&'static str, Self)] = &[("as_is", Exposure::AsIs)];
}

impl Default for Config {
    fn default() -> Self {
        Config { transfer: Transfer::Srgb, gamma: None, exposure: Exposure::AsIs }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        match (self.transfer, self.gamma) {
            (Transfer::Gamma, None) => {
                vec![Fault::new("gamma", "is needed where transfer = \"gamma\"", "nothing").hint("add `gamma = 2.2`")]
            }
            (Transfer::Gamma, Some(gamma)) => Fault::unless_within("gamma", gamma, 0.2..=5.0).into_iter().collect(),
            (other, Some(gamma)) => {
                let rule = format!("has no meaning where transfer = \"{}\"", other.name());
                vec![Fault::new("gamma", rule, gamma).hint("take it out, or set transfer = \"gamma\"")]
            }
            (_, None) => Vec::new(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gamma_belongs_to_its_transfer() {
        let faults = |transfer, gamma| Config { transfer, gamma, ..Config::default() }.check().len();
        assert_eq!(faults(Transfer::Srgb, None), 0);
        assert_eq!(faults(Transfer::Gamma, Some(2.2)), 0);
        for (transfer, gamma) in [
            (Transfer::Gamma, None),
            (Transfer::Gamma, Some(0.0)),
            (Transfer::Gamma, Some(f64::NAN)),
            (Transfer::Linear, Some(2.2)),
        ] {
            assert_eq!(faults(transfer, gamma), 1, "{transfer:?} {gamma:?}");
        }
    }
}
