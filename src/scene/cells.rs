//! Cells: what a triangle sent towards a bin, apart by the light that it was seen in and by what of it reached it. Where a sun is
//! known, the same bin of a triangle may be seen in its light, in a shadow, or at the edge of one.

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

/// Lights that frames of one scene may have been taken in.
pub(crate) const LIGHTS: usize = 3;

/// The bins of the front.
const BINS: Bin = 3600;
const _: () = assert!(BINS as usize == FRONT_BINS);

/// Cells of one light, and of a triangle.
const OF_LIGHT: usize = 3 * FRONT_BINS;
pub(crate) const CELLS: usize = LIGHTS * OF_LIGHT;
const _: () = assert!(CELLS <= 1 << 15);

/// The cell of a bin of the front, in `0..CELLS`: light by light, first those of which nobody can tell, then those in the sun,
/// and those in the shade.
pub(crate) fn cell(light: u8, reach: Reach, bin: Bin) -> Bin {
    let reached = match reach {
        Reach::Untold => 0,
        Reach::Sun => 1,
        Reach::Shade => 2,
    };
    Bin::from(3 * light + reached) * BINS + bin
}

/// What was seen in one light, where the same reached it.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Part {
    /// The light's position in the list of lights.
    pub light: usize,
    /// What of it reached the surface.
    pub reach: Reach,
    /// The sums.
    pub map: SparseMap,
}

/// The sums of a triangle's cells as maps.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct Apart {
    /// All that was seen.
    pub whole: SparseMap,
    /// The same apart, none of them empty; none where all was seen in the first light and nobody can tell what reached it.
    pub parts: Vec<Part>,
}

impl Apart {
    /// Takes ascending cells apart.
    pub(crate) fn of(mut cells: Vec<(Bin, BinSum)>) -> Apart {
        let kind = |cell: Bin| usize::from(cell) / FRONT_BINS;
        if cells.last().is_none_or(|(last, _)| kind(*last) == 0) {
            return Apart { whole: SparseMap { bins: cells }, ..Apart::default() };
        }
        let bin = |cell: Bin| cell % BINS;
        let part = |cells: &[(Bin, BinSum)]| {
            let kind = kind(cells[0].0);
            let reach = [Reach::Untold, Reach::Sun, Reach::Shade][kind % 3];
            let bins = cells.iter().map(|(cell, sum)| (bin(*cell), *sum)).collect();
            Part { light: kind / 3, reach, map: SparseMap { bins } }
        };
        let parts = cells.chunk_by(|a, b| kind(a.0) == kind(b.0)).map(part).collect();
        cells.iter_mut().for_each(|(cell, _)| *cell = bin(*cell));
        cells.sort_unstable_by_key(|(bin, _)| *bin);
        cells.dedup_by(|next, kept| {
            let same = next.0 == kept.0;
            if same {
                kept.1.add(&next.1);
            }
            same
        });
        cells.shrink_to_fit();
        Apart { whole: SparseMap { bins: cells }, parts }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cells_of_one_bin_meet_in_the_whole_and_nowhere_else() {
        let one = |radiance: f32| BinSum::one([radiance; 3], false);
        let cells = [
            (0, Reach::Untold, 7, 0.5),
            (0, Reach::Sun, 7, 1.0),
            (0, Reach::Sun, 3599, 0.25),
            (0, Reach::Shade, 3, 0.125),
            (2, Reach::Untold, 3, 4.0),
            (2, Reach::Shade, 3599, 2.0),
        ];
        let apart = Apart::of(cells.map(|(l, reach, bin, radiance)| (cell(l, reach, bin), one(radiance))).to_vec());
        let both = |a: f32, b: f32| {
            let mut sum = one(a);
            sum.add(&one(b));
            sum
        };
        assert_eq!(apart.whole.bins, [(3, both(0.125, 4.0)), (7, both(0.5, 1.0)), (3599, both(0.25, 2.0))]);
        let part = |light, reach, bins| Part { light, reach, map: SparseMap { bins } };
        let expected = [
            part(0, Reach::Untold, vec![(7, one(0.5))]),
            part(0, Reach::Sun, vec![(7, one(1.0)), (3599, one(0.25))]),
            part(0, Reach::Shade, vec![(3, one(0.125))]),
            part(2, Reach::Untold, vec![(3, one(4.0))]),
            part(2, Reach::Shade, vec![(3599, one(2.0))]),
        ];
        assert_eq!(apart.parts, expected);
        assert_eq!(usize::from(cell(2, Reach::Shade, 3599)), CELLS - 1);
        let untold = vec![(7, one(0.5)), (9, one(0.5))];
        assert_eq!(Apart::of(untold.clone()), Apart { whole: SparseMap { bins: untold }, parts: Vec::new() });
        assert_eq!(Apart::of(Vec::new()), Apart::default());
    }
}
