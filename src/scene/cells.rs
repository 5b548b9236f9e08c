//! Cells: what a triangle sent towards a bin, apart by what reached it when it was seen. Where a sun is known, the same bin of
//! a triangle may be seen in its light, in a shadow, or at the edge of one.

use super::reflectance::{Bin, BinSum, FRONT_BINS, SparseMap};

/// What reached a point when a pixel saw it.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(crate) enum Reach {
    /// Nobody can tell: no sun is known, or an edge between light and shadow is near.
    #[default]
    Untold,
    /// Sun and sky.
    Sun,
    /// The sky alone.
    Shade,
}

/// Cells of a triangle.
pub(crate) const CELLS: usize = 3 * FRONT_BINS;

/// The first cells in the sun, and in the shade.
const SUN: Bin = 3600;
const SHADE: Bin = 7200;
const _: () = assert!(SUN as usize == FRONT_BINS && SHADE as usize == 2 * FRONT_BINS);

/// The cell of a bin of the front, in `0..CELLS`: cells in the sun follow those of which nobody can tell, and those in the shade
/// come last.
pub(crate) fn cell(reach: Reach, bin: Bin) -> Bin {
    match reach {
        Reach::Untold => bin,
        Reach::Sun => SUN + bin,
        Reach::Shade => SHADE + bin,
    }
}

/// The sums of a triangle's cells as maps.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Apart {
    /// All that was seen.
    pub whole: SparseMap,
    /// What was seen in the sun; empty where nothing was.
    pub sun: SparseMap,
    /// What was seen in the shade; empty where nothing was.
    pub shade: SparseMap,
}

impl Apart {
    /// Takes ascending cells apart.
    pub(crate) fn of(mut cells: Vec<(Bin, BinSum)>) -> Apart {
        let first = |from: Bin| cells.partition_point(|(cell, _)| *cell < from);
        let (sun, shade) = (first(SUN), first(SHADE));
        if sun == cells.len() {
            return Apart { whole: SparseMap { bins: cells }, ..Apart::default() };
        }
        let map = |cells: &[(Bin, BinSum)], from: Bin| -> SparseMap {
            SparseMap { bins: cells.iter().map(|(cell, sum)| (cell - from, *sum)).collect() }
        };
        let (sun, shade) = (map(&cells[sun..shade], SUN), map(&cells[shade..], SHADE));
        cells.iter_mut().for_each(|(cell, _)| *cell %= SUN);
        cells.sort_unstable_by_key(|(bin, _)| *bin);
        cells.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1.add(&next.1);
            }
            same
        });
        cells.shrink_to_fit();
        Apart { whole: SparseMap { bins: cells }, sun, shade }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_one_bin_meet_in_the_whole_and_nowhere_else() {
        let one = |radiance: f32| BinSum::one([radiance; 3], false);
        let cells = [(Reach::Untold, 7, 0.5), (Reach::Sun, 7, 1.0), (Reach::Sun, 3599, 0.25), (Reach::Shade, 3, 0.125)];
        let apart = Apart::of(cells.map(|(reach, bin, radiance)| (cell(reach, bin), one(radiance))).to_vec());
        let mut both = one(0.5);
        both.add(&one(1.0));
        assert_eq!(apart.whole.bins, [(3, one(0.125)), (7, both), (3599, one(0.25))]);
        assert_eq!(apart.sun.bins, [(7, one(1.0)), (3599, one(0.25))]);
        assert_eq!(apart.shade.bins, [(3, one(0.125))]);
        let untold = vec![(7, one(0.5)), (9, one(0.5))];
        assert_eq!(Apart::of(untold.clone()), Apart { whole: SparseMap { bins: untold }, ..Apart::default() });
        assert_eq!(Apart::of(Vec::new()), Apart::default());
    }
}
