//! The plan: square blocks of [`PITCH`] metres, each a block of buildings with the street on its near sides, amid fields.
//! Block corners are moved about and raised a little, and a block is the bilinear surface between its four, so straight
//! lines along a block's axes stay straight and neighbours meet without a gap, whatever either is cut into.
//!
//! Everything about a block follows from (seed, column, row): blocks can be made in any order and any number.

use glam::{DVec2, DVec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64;

/// Edge of a block, metres.
pub const PITCH: f64 = 44.0;

/// Rings of field blocks around the town.
pub const MARGIN: i32 = 1;

/// What a block is built with.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Use {
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
    /// How many triangles such a block has, on average: a fixed number, and one to divide by the square of the cells'
    /// edge length in metres. Measured over many seeds.
    pub fn triangles(self) -> (f64, f64) {
        match self {
            Use::Houses => (1729.0, 6703.0),
            Use::Flats => (3459.0, 8819.0),
            Use::Hall => (788.0, 5927.0),
            Use::Park => (2248.0, 4220.0),
            Use::Church => (1694.0, 6611.0),
            Use::Field => (130.0, 950.0),
        }
    }
}

/// The streets that cross a block's near sides.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Streets {
    /// Along the block's left side.
    pub left: bool,
    /// Along the block's bottom side.
    pub bottom: bool,
}

/// Four corners in mesh coordinates: where a block lies.
#[derive(Debug, Clone, Copy)]
pub struct Ground([DVec3; 4]);

impl Ground {
    /// The ground at a place in the block, metres from its corner.
    pub fn place(&self, at: DVec2) -> DVec3 {
        let [a, b, c, d] = self.0;
        let DVec2 { x: u, y: v } = at / PITCH;
        a.lerp(b, u).lerp(d.lerp(c, u), v)
    }
}

/// The plan of a city.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Town {
    /// Seed of everything.
    pub seed: u64,
    /// Town blocks a side, without the fields.
    pub side: i32,
}

impl Town {
    /// Half the edge of the built part, metres.
    pub fn reach(&self) -> f64 {
        f64::from(self.side) * PITCH * 0.5
    }

    /// All blocks, row by row.
    pub fn blocks(&self) -> Vec<[i32; 2]> {
        let range = -MARGIN..self.side + MARGIN;
        range.clone().flat_map(|j| range.clone().map(move |i| [i, j])).collect()
    }

    /// How many triangles the whole has: a fixed number, and one to divide by the square of the cells' edge length.
    pub fn triangles(&self) -> (f64, f64) {
        self.blocks()
            .into_iter()
            .map(|at| self.land_use(at).triangles())
            .fold((0.0, 0.0), |s, t| (s.0 + t.0, s.1 + t.1))
    }

    /// Where a block lies.
    pub fn ground(&self, [i, j]: [i32; 2]) -> Ground {
        Ground([[i, j], [i + 1, j], [i + 1, j + 1], [i, j + 1]].map(|c| self.corner(c)))
    }

    /// What a block is built with. Sixteen neighbours share a hand of cards, so that every use turns up.
    pub fn land_use(&self, [i, j]: [i32; 2]) -> Use {
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

    /// Which streets a block carries: those along town blocks, and two that lead out into the country.
    pub fn streets(&self, [i, j]: [i32; 2]) -> Streets {
        Streets {
            left: i == self.side / 2 || self.is_town([i, j]) || self.is_town([i - 1, j]),
            bottom: j == self.side / 2 || self.is_town([i, j]) || self.is_town([i, j - 1]),
        }
    }

    /// Random numbers of one block for one purpose.
    pub fn rng(&self, purpose: u64, [i, j]: [i32; 2]) -> Pcg64 {
        let place = (u64::from(i as u32) << 32) | u64::from(j as u32);
        Pcg64::seed_from_u64(scramble(scramble(scramble(self.seed) ^ purpose) ^ place))
    }

    fn is_town(&self, block: [i32; 2]) -> bool {
        block.iter().all(|c| (0..self.side).contains(c))
    }

    /// A corner of the plan in mesh coordinates: the grid turned, each corner moved by up to 2 m and raised by up to 1 m.
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
