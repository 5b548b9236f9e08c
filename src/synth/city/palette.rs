//! The materials of a city. Albedos are linear and plausible for the substance; ks is the share of a smooth dielectric's
//! reflection that the surface shows, near 1 for glass, lacquer and sheet metal, small for dull and porous surfaces.

use rand::RngExt;
use rand_pcg::Pcg64;

use super::finish::{Finish, Substance};

/// A random element of a list.
fn pick<T: Copy>(rng: &mut Pcg64, of: &[T]) -> T {
    of[rng.random_range(0..of.len())]
}

/// A colour brightened or darkened by up to `amount`, relative, with a slight tint.
fn vary(rng: &mut Pcg64, kd: [f32; 3], amount: f32) -> [f32; 3] {
    let shade = 1.0 + rng.random_range(-amount..=amount);
    kd.map(|v| (v * shade * (1.0 + rng.random_range(-0.06..=0.06_f32))).clamp(0.02, 0.75))
}

/// Carriageways: old and grey or fresh and black.
pub(super) fn asphalt(rng: &mut Pcg64) -> Finish {
    let (grey, ks) = (rng.random_range(0.07..0.13), rng.random_range(0.2..0.4));
    Finish::new(Substance::Asphalt, [grey, grey, grey * 1.03], ks, rng.random_range(0.6..0.8), 0.045)
}

/// Lane and parking marks.
pub(super) fn marking() -> Finish {
    Finish::new(Substance::Marking, [0.62, 0.62, 0.6], 0.4, 0.45, 0.06)
}

/// Pavements and yards of concrete or slabs.
pub(super) fn paving(rng: &mut Pcg64) -> Finish {
    let kd = pick(rng, &[[0.33, 0.32, 0.3], [0.28, 0.27, 0.26], [0.36, 0.31, 0.25], [0.3, 0.23, 0.19]]);
    Finish::new(Substance::Paving, vary(rng, kd, 0.1), rng.random_range(0.15..0.35), rng.random_range(0.55..0.8), 0.08)
}

/// Gravel paths.
pub(super) fn gravel(rng: &mut Pcg64) -> Finish {
    Finish::new(Substance::Gravel, vary(rng, [0.36, 0.31, 0.24], 0.15), 0.1, 0.9, 0.1)
}

/// Lawns.
pub(super) fn grass(rng: &mut Pcg64) -> Finish {
    let kd = pick(rng, &[[0.07, 0.13, 0.035], [0.09, 0.14, 0.04], [0.06, 0.1, 0.03], [0.12, 0.14, 0.05]]);
    Finish::new(Substance::Grass, vary(rng, kd, 0.15), rng.random_range(0.1..0.25), rng.random_range(0.7..0.9), 0.13)
}

/// Farmland: green, ripe or ploughed.
pub(super) fn crop(rng: &mut Pcg64) -> Finish {
    let kd =
        pick(rng, &[[0.09, 0.15, 0.04], [0.3, 0.25, 0.11], [0.16, 0.11, 0.07], [0.13, 0.17, 0.05], [0.36, 0.31, 0.08]]);
    Finish::new(Substance::Crop, vary(rng, kd, 0.15), rng.random_range(0.05..0.2), rng.random_range(0.7..0.95), 0.14)
}

/// Roof tiles and slates.
pub(super) fn tiles(rng: &mut Pcg64) -> Finish {
    let kd = pick(
        rng,
        &[
            [0.34, 0.12, 0.065],
            [0.28, 0.09, 0.05],
            [0.38, 0.17, 0.09],
            [0.16, 0.08, 0.055],
            [0.09, 0.09, 0.1],
            [0.17, 0.16, 0.16],
        ],
    );
    Finish::new(Substance::Tiles, vary(rng, kd, 0.15), rng.random_range(0.25..0.6), rng.random_range(0.4..0.65), 0.08)
}

/// Coated or bare sheet-metal roofs.
pub(super) fn sheet(rng: &mut Pcg64) -> Finish {
    let kd = pick(
        rng,
        &[
            [0.35, 0.36, 0.37],
            [0.18, 0.2, 0.22],
            [0.09, 0.17, 0.13],
            [0.1, 0.17, 0.28],
            [0.32, 0.07, 0.06],
            [0.5, 0.5, 0.48],
        ],
    );
    Finish::new(Substance::Sheet, vary(rng, kd, 0.12), rng.random_range(0.75..1.0), rng.random_range(0.2..0.4), 0.04)
}

/// Weathered copper: spires.
pub(super) fn copper(rng: &mut Pcg64) -> Finish {
    let mut copper = Finish::new(Substance::Copper, [0.13, 0.28, 0.22], 0.8, rng.random_range(0.3..0.45), 0.1);
    copper.base.ks = [0.7, 0.85, 0.8];
    copper
}

/// Flat roofs: bitumen, gravel or a pale membrane.
pub(super) fn flat_roof(rng: &mut Pcg64) -> Finish {
    let (kd, ks, r) =
        pick(rng, &[([0.08, 0.08, 0.085], 0.35, 0.6), ([0.3, 0.28, 0.25], 0.15, 0.85), ([0.58, 0.58, 0.57], 0.4, 0.5)]);
    Finish::new(Substance::FlatRoof, vary(rng, kd, 0.15), ks, r + rng.random_range(-0.06..0.06), 0.05)
}

/// Rendered and painted walls.
pub(super) fn paint(rng: &mut Pcg64) -> Finish {
    let kd = pick(
        rng,
        &[
            [0.62, 0.6, 0.55],
            [0.6, 0.5, 0.31],
            [0.58, 0.41, 0.25],
            [0.5, 0.27, 0.19],
            [0.4, 0.47, 0.38],
            [0.36, 0.43, 0.52],
            [0.55, 0.52, 0.46],
            [0.6, 0.44, 0.4],
            [0.66, 0.64, 0.62],
        ],
    );
    Finish::new(Substance::Paint, vary(rng, kd, 0.1), rng.random_range(0.1..0.35), rng.random_range(0.55..0.9), 0.05)
}

/// Brick.
pub(super) fn brick(rng: &mut Pcg64) -> Finish {
    let kd = pick(rng, &[[0.27, 0.11, 0.07], [0.34, 0.16, 0.1], [0.38, 0.27, 0.18], [0.2, 0.09, 0.07]]);
    Finish::new(Substance::Brick, vary(rng, kd, 0.12), rng.random_range(0.1..0.3), rng.random_range(0.65..0.85), 0.12)
}

/// Bare concrete and stone.
pub(super) fn stone(rng: &mut Pcg64) -> Finish {
    Finish::new(
        Substance::Stone,
        vary(rng, [0.4, 0.38, 0.34], 0.15),
        rng.random_range(0.15..0.3),
        rng.random_range(0.6..0.85),
        0.08,
    )
}

/// Corrugated or panelled cladding.
pub(super) fn cladding(rng: &mut Pcg64) -> Finish {
    let kd = pick(rng, &[[0.45, 0.46, 0.47], [0.22, 0.26, 0.32], [0.56, 0.54, 0.48], [0.2, 0.3, 0.24]]);
    Finish::new(Substance::Cladding, vary(rng, kd, 0.1), rng.random_range(0.5..0.8), rng.random_range(0.3..0.5), 0.05)
}

/// A window: dark, or with a curtain behind.
pub(super) fn glass(rng: &mut Pcg64) -> Finish {
    let shade = if rng.random_bool(0.3) { rng.random_range(0.12..0.35) } else { rng.random_range(0.03..0.07) };
    Finish::new(
        Substance::Glass,
        vary(rng, [shade, shade, shade * 1.05], 0.05),
        rng.random_range(0.85..1.0),
        rng.random_range(0.05..0.16),
        0.04,
    )
}

/// Photovoltaic panels.
pub(super) fn solar() -> Finish {
    Finish::new(Substance::Solar, [0.035, 0.04, 0.07], 0.95, 0.12, 0.05)
}

/// Painted doors and shutters.
pub(super) fn door(rng: &mut Pcg64) -> Finish {
    let kd = pick(rng, &[[0.2, 0.1, 0.06], [0.08, 0.16, 0.11], [0.1, 0.13, 0.24], [0.3, 0.06, 0.05], [0.5, 0.5, 0.48]]);
    Finish::new(Substance::Door, vary(rng, kd, 0.1), rng.random_range(0.5..0.8), rng.random_range(0.25..0.45), 0.04)
}

/// Car bodies.
pub(super) fn lacquer(rng: &mut Pcg64) -> Finish {
    let kd = pick(
        rng,
        &[
            [0.6, 0.6, 0.6],
            [0.03, 0.03, 0.035],
            [0.3, 0.31, 0.32],
            [0.4, 0.04, 0.04],
            [0.05, 0.09, 0.25],
            [0.12, 0.12, 0.13],
            [0.1, 0.2, 0.16],
        ],
    );
    Finish::new(Substance::Lacquer, vary(rng, kd, 0.1), rng.random_range(0.9..1.0), rng.random_range(0.1..0.2), 0.03)
}

/// Foliage of broad-leaved trees.
pub(super) fn leaves(rng: &mut Pcg64) -> Finish {
    let greens =
        [[0.065, 0.12, 0.03], [0.05, 0.095, 0.028], [0.085, 0.135, 0.035], [0.06, 0.105, 0.04], [0.1, 0.13, 0.03]];
    // Now and then a copper beech.
    let kd = if rng.random_bool(0.06) { [0.12, 0.055, 0.035] } else { pick(rng, &greens) };
    Finish::new(Substance::Leaves, vary(rng, kd, 0.2), rng.random_range(0.2..0.45), rng.random_range(0.45..0.65), 0.28)
}

/// Needles and hedges.
pub(super) fn needles(rng: &mut Pcg64) -> Finish {
    Finish::new(
        Substance::Needles,
        vary(rng, [0.035, 0.07, 0.03], 0.25),
        rng.random_range(0.15..0.3),
        rng.random_range(0.55..0.75),
        0.2,
    )
}

/// Bark.
pub(super) fn bark(rng: &mut Pcg64) -> Finish {
    Finish::new(Substance::Bark, vary(rng, [0.13, 0.09, 0.06], 0.2), 0.1, 0.85, 0.1)
}

/// Ponds.
pub(super) fn water() -> Finish {
    Finish::new(Substance::Water, [0.02, 0.035, 0.03], 0.5, 0.1, 0.0)
}
