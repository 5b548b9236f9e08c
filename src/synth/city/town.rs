//! The map of a city: square blocks of [`PITCH`] metres, each with buildings and with streets on its near sides, amid
//! fields. Block corners are moved about and raised a little, and a block is the bilinear surface between four corners. So
//! straight lines along a block's axes stay straight, and neighbours meet without a gap, however each is cut into cells.
//!
//! A block follows from (seed, column, row) alone: blocks can be made in any order and any number.

use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Edge of a block, metres.
pub(super) const PITCH: f64 = 44.0;

/// Rings of field blocks around the town.
pub(super) const MARGIN: i32 = 1;

/// The use of a block's land.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Use {
    /// Detached houses with gardens.
    Houses,
    /// Rows of flats around a court.
    Flats,
    /// A hall with a car park.
    Hall,
    /// A park.
    Park,
    /// A church on a green.
    Church,
    /// Farmland, without streets of its own.
    Field,
}

impl Use {
    /// The average number of triangles of such a block, measured over many seeds.
    pub(super) fn triangles(self) -> Density {
        let (fixed, areal) = match self {
            Use::Houses => (1729.0, 6703.0),
            Use::Flats => (3459.0, 8819.0),
            Use::Hall => (788.0, 5927.0),
            Use::Park => (2248.0, 4220.0),
            Use::Church => (1694.0, 6611.0),
            Use::Field => (130.0, 950.0),
        };
        Density { fixed, areal }
    }
}

/// A number of triangles that depends on the size of cells.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(super) struct Density {
    /// Triangles whatever the cells.
    pub fixed: f64,
    /// Triangles where cells have edges of 1 m.
    pub areal: f64,
}

impl Density {
    /// The number of triangles where cells have edges of this length, metres.
    pub(super) fn in_cells(self, edge: f64) -> f64 {
        self.fixed + self.areal / (edge * edge)
    }
}

/// The streets that cross a block's near sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Streets {
    /// Along the block's left side.
    pub left: bool,
    /// Along the block's bottom side.
    pub bottom: bool,
}

/// The four corners of a block in mesh coordinates.
#[derive(Debug, Clone, Copy)]
pub(super) struct Ground([DVec3; 4]);

impl Ground {
    /// The ground at a point of the block, metres from the block's corner.
    pub(super) fn point(&self, at: DVec2) -> DVec3 {
        let [a, b, c, d] = self.0;
        let DVec2 { x: u, y: v } = at / PITCH;
        a.lerp(b, u).lerp(d.lerp(c, u), v)
    }
}

/// The map of a city.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Town {
    /// Seed of everything random.
    pub seed: u64,
    /// Town blocks a side, without the fields.
    pub side: i32,
}

impl Town {
    /// Half the edge of the built part, metres.
    pub(super) fn reach(&self) -> f64 {
        f64::from(self.side) * PITCH * 0.5
    }

    /// All blocks, row by row.
    pub(super) fn blocks(&self) -> Vec<[i32; 2]> {
        let range = -MARGIN..self.side + MARGIN;
        range.clone().flat_map(|j| range.clone().map(move |i| [i, j])).collect()
    }

    /// The number of triangles of all blocks together.
    pub(super) fn triangles(&self) -> Density {
        let blocks = self.blocks().into_iter().map(|at| self.land_use(at).triangles());
        blocks.fold(Density::default(), |sum, block| Density {
            fixed: sum.fixed + block.fixed,
            areal: sum.areal + block.areal,
        })
    }

    /// The ground of a block.
    pub(super) fn ground(&self, [i, j]: [i32; 2]) -> Ground {
        Ground([[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|c| self.corner(c)))
    }

    /// The use of a block. Sixteen neighbours share a hand of cards, so that every use turns up.
    pub(super) fn land_use(&self, [i, j]: [i32; 2]) -> Use {
        use Use::{Church, Flats, Hall, Houses, Park};
        if !self.is_town([i, j]) {
            return Use::Field;
        }
        let mut hand = [
            Houses, Flats, Houses, Hall, Park, Houses, Flats, Houses, Houses, Flats, Church, Houses, Flats, Houses,
            Hall, Flats,
        ];
        let mut rng = self.rng(1, [i.div_euclid(4), j.div_euclid(4)]);
        for last in (1..hand.len()).rev() {
            hand.swap(last, rng.random_range(0..=last));
        }
        hand[(j.rem_euclid(4) * 4 + i.rem_euclid(4)) as usize]
    }

    /// The streets of a block: those along town blocks, and two that lead out into the country.
    pub(super) fn streets(&self, [i, j]: [i32; 2]) -> Streets {
        Streets {
            left: i == self.side / 2 || self.is_town([i, j]) || self.is_town([i - 1, j]),
            bottom: j == self.side / 2 || self.is_town([i, j]) || self.is_town([i, j - 1]),
        }
    }

    /// Random numbers of one block for one purpose.
    pub(super) fn rng(&self, purpose: u64, [i, j]: [i32; 2]) -> Pcg64 {
        let position = (u64::from(i.cast_unsigned()) << 32) | u64::from(j.cast_unsigned());
        Pcg64::seed_from_u64(scramble(scramble(scramble(self.seed) ^ purpose) ^ position))
    }

    fn is_town(&self, block: [i32; 2]) -> bool {
        block.iter().all(|c| (0..self.side).contains(c))
    }

    /// A corner of the grid in mesh coordinates: the grid turned, each corner moved by up to 2 m and raised by up to 1 m.
    fn corner(&self, [i, j]: [i32; 2]) -> DVec3 {
        let mut rng = self.rng(2, [i, j]);
        let mut stray = |reach: f64| rng.random_range(-reach..=reach);
        let flat = DVec2::new(f64::from(i), f64::from(j)) * PITCH - self.reach() + DVec2::new(stray(2.0), stray(2.0));
        DVec2::from_angle(0.3).rotate(flat).extend(stray(1.0))
    }
}

/// A bijection that leaves no trace of its argument's order (the finaliser of SplitMix64, Steele et al. 2014).
fn scramble(x: u64) -> u64 {
    let x = x.wrapping_add(0x9E37_79B9_7F4A_7C15);
    let x = (x ^ (x >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
    let x = (x ^ (x >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
    x ^ (x >> 31)
}
