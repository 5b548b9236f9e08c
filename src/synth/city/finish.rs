//! What surfaces are made of: a substance, its material, and how far single triangles stray from it.

use rand::RngExt;
use rand_pcg::Pcg64;

use crate::base::convert::to_u8;
use crate::scene::Material;

/// What a surface is made of.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Substance {
    /// Carriageways.
    Asphalt,
    /// Lane and parking marks.
    Marking,
    /// Concrete or slabs.
    Paving,
    /// Gravel.
    Gravel,
    /// Lawns.
    Grass,
    /// Farmland.
    Crop,
    /// Roof tiles and slates.
    Tiles,
    /// Sheet metal.
    Sheet,
    /// Weathered copper.
    Copper,
    /// Coverings of flat roofs.
    FlatRoof,
    /// Render and paint.
    Paint,
    /// Brick.
    Brick,
    /// Bare concrete and stone.
    Stone,
    /// Panels on walls.
    Cladding,
    /// Panes.
    Glass,
    /// Photovoltaic panels.
    Solar,
    /// Doors and shutters.
    Door,
    /// Car bodies.
    Lacquer,
    /// Foliage.
    Leaves,
    /// Needles and hedges.
    Needles,
    /// Bark.
    Bark,
    /// Ponds.
    Water,
}

/// All substances, in the order of their numbers.
const ALL: [Substance; 22] = [
    Substance::Asphalt,
    Substance::Marking,
    Substance::Paving,
    Substance::Gravel,
    Substance::Grass,
    Substance::Crop,
    Substance::Tiles,
    Substance::Sheet,
    Substance::Copper,
    Substance::FlatRoof,
    Substance::Paint,
    Substance::Brick,
    Substance::Stone,
    Substance::Cladding,
    Substance::Glass,
    Substance::Solar,
    Substance::Door,
    Substance::Lacquer,
    Substance::Leaves,
    Substance::Needles,
    Substance::Bark,
    Substance::Water,
];

impl Substance {
    /// The substance's number.
    pub(super) fn number(self) -> u8 {
        ALL.iter().position(|one| *one == self).map_or(0, to_u8)
    }

    /// The substance of a number.
    pub(super) fn numbered(number: usize) -> Substance {
        ALL.get(number).copied().unwrap_or(Substance::Stone)
    }

    /// Whether the substance mirrors or shows what lies behind it, which no material of one lobe does.
    pub(super) fn is_clear(self) -> bool {
        matches!(self, Substance::Glass | Substance::Water)
    }
}

/// The finish of a surface: a substance, a material, and how far single triangles stray from it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Finish {
    /// What the surface is made of.
    pub substance: Substance,
    /// The material before triangles stray.
    pub base: Material,
    /// Largest relative deviation of a triangle's kd, ks and r.
    pub grain: f32,
    /// How much brighter the surface is than another of the same make.
    pub tone: f32,
    /// The number that surfaces of the same make share.
    pub make: u64,
}

impl Finish {
    /// A finish of one substance, the same for all channels of ks.
    pub(super) fn new(substance: Substance, kd: [f32; 3], ks: f32, r: f32, grain: f32) -> Finish {
        let [red, green, blue] = kd.map(|v| u64::from(v.to_bits()));
        let make = red << 32 ^ green << 16 ^ blue ^ u64::from(r.to_bits()) << 24;
        Finish { substance, base: Material { kd, ks: [ks; 3], r }, grain, tone: 1.0, make }
    }

    /// The material of one triangle.
    pub(super) fn sample(&self, rng: &mut Pcg64) -> Material {
        let mut stray = |amount: f32| 1.0 + amount * self.grain * rng.random_range(-1.0..=1.0_f32);
        let (shade, gloss, width) = (stray(1.0), stray(1.0), stray(0.6));
        let kd = self.base.kd.map(|v| (v * shade * stray(0.3)).clamp(0.0, 1.0));
        let ks = self.base.ks.map(|v| (v * gloss).clamp(0.0, 1.0));
        Material { kd, ks, r: (self.base.r * width).clamp(0.0, 1.0) }
    }

    /// The same finish, brighter or darker.
    pub(super) fn shaded(mut self, factor: f32) -> Finish {
        self.base.kd = self.base.kd.map(|v| (v * factor).clamp(0.0, 1.0));
        self.tone *= factor;
        self
    }
}
