//! Merge: the materials of all shards become one row a triangle, and what was hardly seen is filled.

use serde::Serialize;

use super::Fault;
use crate::scene::reflectance::FRONT_BINS;

/// Section `[merge]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// Bins that a triangle's map must have filled for its material to count, 1 to 3,600.
    pub min_bins: u32,
    /// Whether triangles with less are filled from their nearest observed neighbours; else they are NaN.
    pub fill: bool,
}

impl Default for Config {
    fn default() -> Self {
        Config { min_bins: 1, fill: true }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        Fault::unless_within("min_bins", self.min_bins, 1..=FRONT_BINS as u32).into_iter().collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_map_fills_more_than_its_front() {
        for (min_bins, faults) in [(0, 1), (1, 0), (3600, 0), (3601, 1)] {
            assert_eq!(Config { min_bins, ..Config::default() }.check().len(), faults, "{min_bins}");
        }
    }
}
