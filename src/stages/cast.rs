//! Cast: a linear image becomes observations, one ray a pixel, tile by tile.

use serde::Serialize;

use super::Fault;

/// Section `[cast]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// Edge length of a tile, pixels: a power of two, 8 to 256. Rays of a tile are traced together and its observations
    /// summed together, so larger tiles write less and hold more. The result does not depend on it.
    pub tile: u32,
}

impl Default for Config {
    fn default() -> Self {
        Config { tile: 32 }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        if (8..=256).contains(&self.tile) && self.tile.is_power_of_two() {
            return Vec::new();
        }
        vec![Fault::new("tile", "must be a power of two, 8 to 256", self.tile)]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_powers_of_two() {
        for (tile, faults) in [(8, 0), (32, 0), (256, 0), (0, 1), (4, 1), (33, 1), (512, 1), (u32::MAX, 1)] {
            assert_eq!(Config { tile }.check().len(), faults, "{tile}");
        }
    }
}
