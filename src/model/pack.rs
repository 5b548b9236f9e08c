//! Maps as models take them.
//!
//! A model of `bins` gets maps of one size together. Each map is filled up to the least of a few sizes that holds it, so its
//! arithmetic does not depend on the maps beside it. A map with more bins than the model takes keeps a fixed choice of them.

use super::contract::{BIN, Contract, Input};
use crate::scene::reflectance::{BINS, Bin, COLUMNS, ROWS, SparseMap, direction_of};

/// The sizes of sets of bins. Scenes fill 5 to 50 bins, half of their maps under 16.
const SIZES: [usize; 4] = [8, 16, 32, 64];

impl Input {
    /// The name of the graph's input.
    pub(super) fn name(self) -> &'static str {
        match self {
            Input::Dense { .. } => "map",
            Input::Bins { .. } => "bins",
        }
    }

    /// The sizes that maps are filled up to, ascending; a dense map has one size.
    pub fn sizes(self) -> Vec<usize> {
        match self {
            Input::Dense { .. } => vec![BINS],
            Input::Bins { most } => SIZES.into_iter().filter(|&size| size < most).chain([most]).collect(),
        }
    }

    /// The number of values of a map of this size.
    pub fn values(self, size: usize) -> usize {
        size * match self {
            Input::Dense { channels } => channels,
            Input::Bins { .. } => BIN,
        }
    }

    /// Writes a map into zeros.
    pub fn write(self, map: &SparseMap, out: &mut [f32]) {
        match self {
            Input::Dense { channels } => map.write_dense(channels, out),
            Input::Bins { most } => write_bins(map, most, out),
        }
    }
}

/// The index in `sizes` of the least size that holds `map`; see [`Input::sizes`].
pub(super) fn least_size(sizes: &[usize], map: &SparseMap) -> usize {
    sizes.partition_point(|&size| size < map.bins.len()).min(sizes.len() - 1)
}

impl Contract {
    /// The shape of `maps` maps of this size.
    pub(super) fn shape(&self, maps: usize, size: usize) -> Vec<usize> {
        match self.input {
            Input::Dense { channels } => vec![maps, channels, ROWS, COLUMNS],
            Input::Bins { .. } => vec![maps, size, BIN],
        }
    }
}

fn write_bins(map: &SparseMap, most: usize, out: &mut [f32]) {
    let last = if map.bins.len() > most {
        let mut ranks: Vec<u32> = map.bins.iter().map(|(bin, _)| rank(*bin)).collect();
        *ranks.select_nth_unstable(most - 1).1
    } else {
        u32::MAX
    };
    let kept = map.bins.iter().filter(|(bin, _)| rank(*bin) <= last);
    for (row, (bin, sum)) in out.as_chunks_mut::<BIN>().0.iter_mut().zip(kept) {
        let ([x, y, z], [r, g, b]) = (direction_of(*bin).to_array(), sum.mean());
        *row = [x, y, z, r, g, b, sum.count as f32];
    }
}

/// The rank of a bin: if a map has too many bins, those of the lowest ranks are kept. No two bins have the same rank, and no
/// region is preferred.
fn rank(bin: Bin) -> u32 {
    // An odd factor permutes the numbers below 2^32: the golden ratio's, as in Fibonacci hashing (Knuth, vol. 3, 6.4).
    u32::from(bin).wrapping_mul(0x9E37_79B9)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::reflectance::{BinSum, FRONT_BINS};

    fn map(bins: impl Iterator<Item = usize>) -> SparseMap {
        SparseMap { bins: bins.map(|b| (Bin::try_from(b).unwrap(), BinSum::one([0.25, 0.5, 1.0], false))).collect() }
    }

    #[test]
    fn a_map_is_filled_up_to_the_least_size_that_holds_it() {
        let input = Input::Bins { most: 24 };
        assert_eq!(input.sizes(), [8, 16, 24]);
        for (bins, size) in [(0, 8), (8, 8), (9, 16), (17, 24), (24, 24), (25, 24), (3600, 24)] {
            assert_eq!(input.sizes()[least_size(&input.sizes(), &map(0..bins))], size, "{bins}");
        }
        assert_eq!(Input::Bins { most: 8 }.sizes(), [8]);
        assert_eq!(least_size(&Input::Dense { channels: 4 }.sizes(), &map(0..99)), 0);
    }

    #[test]
    fn rows_hold_direction_radiance_and_count_and_the_rest_is_zero() {
        let mut out = vec![0.0; 8 * BIN];
        Input::Bins { most: 64 }.write(&map([5, 3000].into_iter()), &mut out);
        let d = direction_of(3000);
        assert_eq!(out[BIN..2 * BIN], [d.x, d.y, d.z, 0.25, 0.5, 1.0, 1.0]);
        assert!(out[2 * BIN..].iter().all(|v| *v == 0.0));
    }

    #[test]
    fn of_too_many_bins_a_spread_choice_is_kept() {
        let mut out = vec![0.0; 64 * BIN];
        Input::Bins { most: 64 }.write(&map(0..FRONT_BINS), &mut out);
        let rows = out.as_chunks::<BIN>().0;
        assert!(rows.iter().all(|row| row[6] == 1.0));
        // Every sixth of the azimuth has its share.
        let mut sixths = [0; 6];
        for row in rows {
            let turn = (row[1].atan2(row[0]) / std::f32::consts::PI + 1.0) * 2.999;
            sixths[(1..6u8).filter(|n| turn >= f32::from(*n)).count()] += 1;
        }
        assert!(sixths.iter().all(|n| (6..=16).contains(n)), "{sixths:?}");
    }
}
