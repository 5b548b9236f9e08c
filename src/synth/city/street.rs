//! Streets along a block's near sides, and the cars on these streets. A street is [`WIDTH`] wide: a pavement, two lanes, a
//! pavement.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::finish::Finish;
use super::surface::{Block, Rect, Spot};
use super::town::{PITCH, Streets};
use super::{greenery, palette};
use crate::base::convert::Cut;
use crate::scene::Material;

/// Width of a street with its pavements, metres.
pub(super) const WIDTH: f64 = 10.0;
/// Where the carriageway begins and ends across the street.
const ROAD: [f64; 2] = [2.2, 7.8];

/// The finishes of a block's streets.
struct Paint {
    road: Finish,
    paving: Finish,
    verge: Finish,
    mark: Finish,
}

/// Paves the strips along a block's near sides; a strip without a street is covered with `verge`.
pub(super) fn streets(block: &mut Block, streets: Streets, in_town: bool, verge: Finish) {
    let paving = if in_town { palette::paving(&mut block.rng) } else { palette::grass(&mut block.rng) };
    let paint = Paint { road: palette::asphalt(&mut block.rng), paving, verge, mark: palette::marking() };
    strip(block, &paint, streets.left, in_town, true);
    strip(block, &paint, streets.bottom, in_town, false);
    crossing(block, &paint, streets);
}

/// A rectangle `across` and `along` a street, which runs along y if `upright`, else along x.
fn lane(upright: bool, across: [f64; 2], along: [f64; 2]) -> Rect {
    let [a, b] = across;
    let [c, d] = along;
    if upright { Rect::new(a, b, c, d) } else { Rect::new(c, d, a, b) }
}

/// One strip: a street with its crossings and marks, or the verge.
fn strip(block: &mut Block, paint: &Paint, street: bool, in_town: bool, upright: bool) {
    let along = [WIDTH, PITCH];
    if !street {
        let cell = 3.0 * block.cell;
        block.floor_cells(lane(upright, [0.0, WIDTH], along), cell, |_, _| paint.verge);
        return;
    }
    let [left, right] = ROAD;
    block.floor(lane(upright, [0.0, left], along), &paint.paving);
    block.floor(lane(upright, [right, WIDTH], along), &paint.paving);
    // A zebra crossing at either end, dashes down the middle between.
    let (mut from, mut to) = (WIDTH, PITCH);
    if in_town && block.rng.random_bool(0.6) {
        zebra(block, paint, upright, [from, from + 2.6]);
        from += 2.6;
    }
    if in_town && block.rng.random_bool(0.6) {
        to -= 2.6;
        zebra(block, paint, upright, [to, PITCH]);
    }
    let middle = 0.5 * (left + right);
    block.floor(lane(upright, [left, middle - 0.12], [from, to]), &paint.road);
    block.floor(lane(upright, [middle + 0.12, right], [from, to]), &paint.road);
    let count = ((to - from) / 3.0).round().max(1.0);
    for dash in 0..usize::cut(count) {
        let at = |k: usize| from + (to - from) * k as f64 / count;
        let finish = if dash % 2 == 0 { paint.mark } else { paint.road };
        block.floor(lane(upright, [middle - 0.12, middle + 0.12], [at(dash), at(dash + 1)]), &finish);
    }
    if in_town {
        furnish(block, upright);
    }
}

/// A zebra crossing.
fn zebra(block: &mut Block, paint: &Paint, upright: bool, along: [f64; 2]) {
    let [left, right] = ROAD;
    let stripes = 11;
    for k in 0..stripes {
        let at = |k: usize| left + (right - left) * k as f64 / stripes as f64;
        let finish = if k % 2 == 1 { paint.mark } else { paint.road };
        block.floor(lane(upright, [at(k), at(k + 1)], along), &finish);
    }
}

/// Trees along the pavements and cars along the kerbs.
fn furnish(block: &mut Block, upright: bool) {
    let point = |across: f64, along: f64| if upright { DVec2::new(across, along) } else { DVec2::new(along, across) };
    if block.rng.random_bool(0.45) {
        let across = if block.rng.random_bool(0.5) { 1.0 } else { WIDTH - 1.0 };
        let mut along = WIDTH + block.rng.random_range(3.0..6.0);
        while along < PITCH - 3.0 {
            let height = block.rng.random_range(4.5..6.5);
            greenery::tree(block, point(across, along), height);
            along += block.rng.random_range(8.0..11.0);
        }
    }
    for (across, chance) in [(ROAD[0] + 1.1, 0.25), (ROAD[1] - 1.1, 0.25)] {
        let mut along = WIDTH + 7.0;
        while along < PITCH - 6.0 {
            if block.rng.random_bool(chance) {
                let turn = if upright { FRAC_PI_2 } else { 0.0 };
                let way = if block.rng.random_bool(0.5) { PI } else { 0.0 };
                let askew = block.rng.random_range(-0.03..0.03);
                car(block, Spot::new(point(across, along), turn + way + askew));
            }
            along += 5.6;
        }
    }
}

/// The square where the two strips meet.
fn crossing(block: &mut Block, paint: &Paint, streets: Streets) {
    let [left, right] = ROAD;
    let cuts = [0.0, left, right, WIDTH];
    for (i, x) in cuts.windows(2).enumerate() {
        for (j, y) in cuts.windows(2).enumerate() {
            let on_road = (streets.left && i == 1) || (streets.bottom && j == 1);
            let finish = match (on_road, streets.left || streets.bottom) {
                (true, _) => paint.road,
                (false, true) => paint.paving,
                (false, false) => paint.verge,
            };
            block.floor(Rect::new(x[0], x[1], y[0], y[1]), &finish);
        }
    }
}

/// A parked car, its length along the spot's x axis.
pub(super) fn car(block: &mut Block, spot: Spot) {
    let paint = palette::lacquer(&mut block.rng);
    let pane = palette::glass(&mut block.rng);
    let glass = Finish { base: Material { kd: [0.03; 3], ..pane.base }, grain: 0.03, ..pane };
    let tall = block.rng.random_range(1.35..1.75);
    let (back, front, wide, belt) = (-2.1, 2.1, 0.88, 0.9);
    // The cabin narrows from its base at the belt line to its roof.
    let (base, roof) = ([-1.7, 1.0], [-1.3, 0.3]);
    let ring = |[x0, x1]: [f64; 2], y: f64, z: f64| {
        [DVec3::new(x0, -y, z), DVec3::new(x1, -y, z), DVec3::new(x1, y, z), DVec3::new(x0, y, z)]
    };
    let (sill, shoulder) = (ring([back, front], wide, 0.15), ring([back, front], wide, belt));
    let (waist, top) = (ring(base, wide, belt), ring(roof, 0.68, tall));
    for k in 0..4 {
        let next = (k + 1) % 4;
        block.patch(spot, [sill[k], sill[next], shoulder[next], shoulder[k]], &paint);
        block.patch(spot, [waist[k], waist[next], top[next], top[k]], &glass);
    }
    block.patch(spot, top, &paint);
    block.patch(spot, ring([base[1], front], wide, belt), &paint);
    block.patch(spot, ring([back, base[0]], wide, belt), &paint);
}
