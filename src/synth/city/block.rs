//! The blocks between the streets: for each use of a block, its ground, its buildings and its trees.

use std::f64::consts::{FRAC_PI_2, PI};

use glam::DVec2;
use rand::RngExt;

use super::building::{self, Body, Facade, Inlay, Pitch};
use super::finish::Finish;
use super::street::{self, WIDTH};
use super::surface::{Block, Part, Rect, Spot, Surface};
use super::town::{PITCH, Town, Use};
use super::world::World;
use super::{greenery, palette};
use crate::base::convert::Cut;

/// The triangles of one block.
pub(super) fn build(town: &Town, at: [i32; 2], cell: f64, world: World) -> Surface {
    let mut block = Block {
        surface: Surface::default(),
        rng: town.rng(0, at),
        ground: town.ground(at),
        cell,
        world,
        part: Part::Both,
    };
    let land_use = town.land_use(at);
    let in_town = land_use != Use::Field;
    let green = if in_town { palette::grass(&mut block.rng) } else { palette::crop(&mut block.rng) };
    street::streets(&mut block, town.streets(at), in_town, green);
    match land_use {
        Use::Houses => houses(&mut block),
        Use::Flats => flats(&mut block),
        Use::Hall => hall(&mut block),
        Use::Park => park(&mut block),
        Use::Church => church(&mut block),
        Use::Field => field(&mut block, green),
    }
    block.surface
}

/// The ground around a hole. The hole is a little smaller than the building over it, so that no gap shows.
fn floor_around(block: &mut Block, lot: Rect, hole: Rect, finishes: [&Finish; 4]) {
    let (hole_low, hole_high) = (hole.low + 0.04, hole.high - 0.04);
    let [south, east, north, west] = finishes;
    block.floor(Rect::new(lot.low.x, lot.high.x, lot.low.y, hole_low.y), south);
    block.floor(Rect::new(lot.low.x, lot.high.x, hole_high.y, lot.high.y), north);
    block.floor(Rect::new(lot.low.x, hole_low.x, hole_low.y, hole_high.y), west);
    block.floor(Rect::new(hole_high.x, lot.high.x, hole_low.y, hole_high.y), east);
}

/// Two rows of lots back to back.
fn houses(block: &mut Block) {
    let middle = 0.5 * (WIDTH + PITCH);
    for (y0, y1, turn) in [(WIDTH, middle, 0.0), (middle, PITCH, PI)] {
        let count = block.rng.random_range(2..=3);
        let width = (PITCH - WIDTH) / f64::from(count);
        for k in 0..count {
            let x0 = WIDTH + f64::from(k) * width;
            house(block, Rect::new(x0, x0 + width, y0, y1), turn);
        }
    }
}

/// A lot with its house, garden, hedge and trees; `turn` is 0 where the street lies on its -y side, else pi.
fn house(block: &mut Block, lot: Rect, turn: f64) {
    let size = lot.size();
    let wide = (0.5 * size.x - block.rng.random_range(1.3..2.2)).min(block.rng.random_range(4.6..6.2));
    // Never deeper than wide: ridges run along the street.
    let half = DVec2::new(wide, wide.min(block.rng.random_range(3.6..4.6)));
    let garden = block.rng.random_range(2.4..4.0);
    let side = if turn == 0.0 { 1.0 } else { -1.0 };
    let front = if turn == 0.0 { lot.low.y } else { lot.high.y };
    let slack = 0.5 * size.x - half.x - 0.8;
    let centre =
        DVec2::new(lot.centre().x + slack * block.rng.random_range(-0.8..0.8), front + side * (garden + half.y));
    let hole = Rect { low: centre - half, high: centre + half };
    let (lawn, yard, drive) =
        (palette::grass(&mut block.rng), palette::grass(&mut block.rng), palette::paving(&mut block.rng));
    let east = if block.rng.random_bool(0.5) { drive } else { lawn };
    let (south, north) = if turn == 0.0 { (lawn, yard) } else { (yard, lawn) };
    floor_around(block, lot, hole, [&south, &east, &north, &lawn]);

    let wall =
        if block.rng.random_bool(0.75) { palette::paint(&mut block.rng) } else { palette::brick(&mut block.rng) };
    let facade = Facade {
        wall,
        plinth: wall,
        bay: block.rng.random_range(2.4..3.0),
        storey: block.rng.random_range(2.7..3.0),
        window: DVec2::new(block.rng.random_range(1.0..1.4), block.rng.random_range(1.2..1.5)),
        sill: 0.9,
        shops: false,
    };
    let body = Body { half, storeys: block.rng.random_range(1..=2) };
    let cover =
        if block.rng.random_bool(0.8) { palette::tiles(&mut block.rng) } else { palette::sheet(&mut block.rng) };
    let solar = block.rng.random_bool(0.35);
    let inlay = solar.then(|| Inlay { across: [0.25, 0.78], up: [0.28, 0.8], finish: palette::solar() });
    let rise = half.y * block.rng.random_range(0.55..0.95);
    let eaves = body.storeys as f64 * facade.storey;
    let spot = Spot::new(centre, turn);
    building::walls(block, spot, body, &facade, [Some(0.0); 4]);
    if block.rng.random_bool(0.65) {
        building::gable(block, spot, half, Pitch { eaves, rise }, &cover, &wall, inlay);
    } else {
        building::hip(block, spot, half, Pitch { eaves, rise }, &cover, inlay);
    }
    let stack = DVec2::new(half.x * block.rng.random_range(-0.5..0.5), half.y * 0.3);
    building::chimney(block, spot, stack, [eaves + 0.4 * rise, eaves + rise + 0.7]);

    let back = if turn == 0.0 {
        Rect { low: DVec2::new(lot.low.x, hole.high.y + 1.5), high: lot.high }
    } else {
        Rect { low: lot.low, high: DVec2::new(lot.high.x, hole.low.y - 1.5) }
    };
    greenery::grove(block, back, 26.0, 3.5..7.5);
    if block.rng.random_bool(0.5) {
        let edge = front + side * 0.5;
        let inner = lot.low.x + 0.6..lot.high.x - 3.2;
        greenery::hedge(block, Rect::new(inner.start, inner.end, edge - 0.35, edge + 0.35));
    }
    if east == drive && lot.high.x - hole.high.x > 2.2 {
        let at = DVec2::new(0.5 * (hole.high.x + lot.high.x), centre.y);
        street::car(block, Spot::new(at, FRAC_PI_2));
    }
}

/// Two rows of flats along the streets, a court with trees and cars between.
fn flats(block: &mut Block) {
    let depth = block.rng.random_range(10.5..12.0);
    for (y0, turn) in [(WIDTH + 0.6, 0.0), (PITCH - 0.6 - depth, PI)] {
        let count = block.rng.random_range(2..=3);
        let width = (PITCH - WIDTH - 1.2) / f64::from(count);
        let storeys: Vec<usize> = (0..count).map(|_| block.rng.random_range(3..=5)).collect();
        let storey = 3.0;
        let row = Rect::new(WIDTH + 0.6, PITCH - 0.6, y0, y0 + depth);
        let paving = palette::paving(&mut block.rng);
        let strip = Rect::new(WIDTH, PITCH, y0 - 0.6, y0 + depth + 0.6);
        floor_around(block, strip, row, [&paving; 4]);
        for k in 0..count as usize {
            let centre = DVec2::new(row.low.x + (k as f64 + 0.5) * width, y0 + 0.5 * depth);
            let neighbour = |n: Option<usize>| match n.and_then(|n| storeys.get(n)) {
                None => Some(0.0),
                Some(&n) if n >= storeys[k] => None,
                Some(&n) => Some(n as f64 * storey),
            };
            let (west, east) = (neighbour(k.checked_sub(1)), neighbour(Some(k + 1)));
            // Turned round, the right-hand neighbour is the one before.
            let (right, left) = if turn == 0.0 { (east, west) } else { (west, east) };
            let body = Body { half: DVec2::new(0.5 * width, 0.5 * depth), storeys: storeys[k] };
            flat_house(block, Spot::new(centre, turn), body, storey, [Some(0.0), right, Some(0.0), left]);
        }
    }
    let court = Rect::new(WIDTH, PITCH, WIDTH + depth + 1.2, PITCH - depth - 1.2);
    let (yard, lawn) = (palette::asphalt(&mut block.rng), palette::grass(&mut block.rng));
    let split = block.rng.random_range(22.0..34.0);
    block.floor(Rect::new(WIDTH, split, court.low.y, court.high.y), &yard);
    block.floor(Rect::new(split, PITCH, court.low.y, court.high.y), &lawn);
    greenery::grove(block, Rect::new(split, PITCH, court.low.y, court.high.y), 22.0, 4.0..8.0);
    let mut x = WIDTH + 2.0;
    while x < split - 1.5 {
        if block.rng.random_bool(0.6) {
            street::car(block, Spot::new(DVec2::new(x, court.high.y - 2.9), FRAC_PI_2));
        }
        x += 2.7;
    }
}

/// One house of a row of flats.
fn flat_house(block: &mut Block, spot: Spot, body: Body, storey: f64, sides: [Option<f64>; 4]) {
    let wall = if block.rng.random_bool(0.8) { palette::paint(&mut block.rng) } else { palette::brick(&mut block.rng) };
    let shops = block.rng.random_bool(0.4);
    let plinth = if shops { palette::stone(&mut block.rng) } else { wall.shaded(0.75) };
    let window = DVec2::new(block.rng.random_range(1.2..1.7), block.rng.random_range(1.4..1.7));
    let bay = block.rng.random_range(2.7..3.3);
    building::walls(block, spot, body, &Facade { wall, plinth, bay, storey, window, sill: 0.85, shops }, sides);
    let top = body.storeys as f64 * storey;
    if block.rng.random_bool(0.6) {
        let cover = palette::flat_roof(&mut block.rng);
        building::flat(block, spot, body.half, top, &cover, &wall.shaded(0.9));
    } else {
        let cover =
            if block.rng.random_bool(0.6) { palette::tiles(&mut block.rng) } else { palette::sheet(&mut block.rng) };
        let skylights = Inlay { across: [0.4, 0.6], up: [0.3, 0.6], finish: palette::glass(&mut block.rng) };
        let inlay = block.rng.random_bool(0.5).then_some(skylights);
        let rise = body.half.y * block.rng.random_range(0.35..0.6);
        building::gable(block, spot, body.half, Pitch { eaves: top, rise }, &cover, &wall, inlay);
    }
}

/// A hall of sheet metal with a car park before it.
fn hall(block: &mut Block) {
    let half = DVec2::new(block.rng.random_range(13.0..15.0), block.rng.random_range(7.5..9.0));
    let centre = DVec2::new(0.5 * (WIDTH + PITCH), PITCH - 1.5 - half.y);
    let hole = Rect { low: centre - half, high: centre + half };
    let (yard, lawn) = (palette::asphalt(&mut block.rng), palette::grass(&mut block.rng));
    let park = Rect::new(WIDTH, PITCH, WIDTH + 1.5, WIDTH + 7.0);
    block.floor(Rect::new(WIDTH, PITCH, WIDTH, park.low.y), &lawn);
    bays(block, park, &yard);
    let rest = Rect::new(WIDTH, PITCH, park.high.y, PITCH);
    floor_around(block, rest, hole, [&yard, &yard, &lawn, &yard]);

    let wall = palette::cladding(&mut block.rng);
    let storey = block.rng.random_range(5.0..6.5);
    let facade =
        Facade { wall, plinth: wall, bay: 4.0, storey, window: DVec2::new(2.6, 1.2), sill: storey - 2.2, shops: false };
    let spot = Spot::new(centre, 0.0);
    building::walls(block, spot, Body { half, storeys: 1 }, &facade, [Some(0.0); 4]);
    let cover = palette::sheet(&mut block.rng);
    if block.rng.random_bool(0.6) {
        let skylight = Inlay { across: [0.1, 0.9], up: [0.4, 0.6], finish: palette::glass(&mut block.rng) };
        let rise = half.y * 0.25;
        building::gable(block, spot, half, Pitch { eaves: storey, rise }, &cover, &wall, Some(skylight));
    } else {
        let cover = palette::flat_roof(&mut block.rng);
        building::flat(block, spot, half, storey, &cover, &wall);
    }
    greenery::grove(block, Rect::new(WIDTH, PITCH, WIDTH - 0.6, park.low.y + 1.0), 40.0, 3.5..5.0);
}

/// Parking bays, 2.6 m wide, with lines between and cars in some.
fn bays(block: &mut Block, rect: Rect, yard: &Finish) {
    let count = usize::cut(rect.size().x / 2.6);
    let width = rect.size().x / count as f64;
    let mark = palette::marking();
    for k in 0..count {
        let x = rect.low.x + k as f64 * width;
        block.floor(Rect::new(x, x + 0.2, rect.low.y, rect.high.y), &mark);
        block.floor(Rect::new(x + 0.2, x + width, rect.low.y, rect.high.y), yard);
        if block.rng.random_bool(0.5) {
            let way = if block.rng.random_bool(0.5) { FRAC_PI_2 } else { -FRAC_PI_2 };
            street::car(block, Spot::new(DVec2::new(x + 0.1 + 0.5 * width, rect.centre().y), way));
        }
    }
}

/// Lawns, gravel paths crossing, many trees.
fn park(block: &mut Block) {
    let (path, half) = (palette::gravel(&mut block.rng), 1.3);
    let middle = DVec2::new(block.rng.random_range(22.0..32.0), block.rng.random_range(22.0..32.0));
    let lawn = palette::grass(&mut block.rng);
    let cuts = |m: f64| [WIDTH, m - half, m + half, PITCH];
    for (i, x) in cuts(middle.x).windows(2).enumerate() {
        for (j, y) in cuts(middle.y).windows(2).enumerate() {
            let rect = Rect::new(x[0], x[1], y[0], y[1]);
            if i == 1 || j == 1 {
                block.floor(rect, &path);
            } else {
                if block.world == World::Real && i == 2 && j == 2 && rect.size().min_element() > 8.0 {
                    pond(block, rect, &lawn);
                    continue;
                }
                block.floor(rect, &lawn);
                greenery::grove(block, rect, 42.0, 5.0..11.0);
            }
        }
    }
}

/// A lawn around a pond.
fn pond(block: &mut Block, rect: Rect, lawn: &Finish) {
    let water = Rect { low: rect.low + 2.0, high: rect.high - 2.0 };
    floor_around(block, rect, water, [lawn; 4]);
    block.floor(water, &palette::water());
}

/// A church on a green: a steep nave, a tower with a copper spire.
fn church(block: &mut Block) {
    let half = DVec2::new(10.0, 4.8);
    let nave = DVec2::new(28.0, 27.0);
    let tower_half = DVec2::splat(2.9);
    let tower = nave - DVec2::new(half.x + tower_half.x - 0.3, 0.0);
    let (lawn, path) = (palette::grass(&mut block.rng), palette::gravel(&mut block.rng));
    // The tower's strip of ground lies left of the nave's.
    let split = nave.x - half.x;
    let (left, right) = (Rect::new(WIDTH, split, WIDTH, PITCH), Rect::new(split, PITCH, WIDTH, PITCH));
    floor_around(
        block,
        left,
        Rect { low: tower - tower_half, high: DVec2::new(split, tower.y + tower_half.y) },
        [&path, &lawn, &lawn, &path],
    );
    floor_around(block, right, Rect { low: nave - half, high: nave + half }, [&lawn; 4]);

    let wall = if block.rng.random_bool(0.5) { palette::stone(&mut block.rng) } else { palette::brick(&mut block.rng) };
    let facade =
        Facade { wall, plinth: wall, bay: 4.0, storey: 7.0, window: DVec2::new(1.3, 3.6), sill: 1.8, shops: false };
    let cover = palette::tiles(&mut block.rng);
    let spot = Spot::new(nave, 0.0);
    building::walls(block, spot, Body { half, storeys: 1 }, &facade, [Some(0.0); 4]);
    building::gable(block, spot, half, Pitch { eaves: 7.0, rise: 6.0 }, &cover, &wall, None);
    let facade = Facade { bay: 5.8, storey: 5.6, window: DVec2::new(1.2, 2.2), ..facade };
    let spot = Spot::new(tower, -FRAC_PI_2);
    building::walls(block, spot, Body { half: tower_half, storeys: 3 }, &facade, [Some(0.0); 4]);
    let copper = palette::copper(&mut block.rng);
    building::hip(block, spot, tower_half, Pitch { eaves: 16.8, rise: 8.5 }, &copper, None);
    for rect in
        [Rect::new(WIDTH, PITCH, WIDTH, nave.y - half.y - 2.0), Rect::new(WIDTH, PITCH, nave.y + half.y + 2.0, PITCH)]
    {
        greenery::grove(block, rect, 48.0, 5.0..10.0);
    }
}

/// Farmland in coarse cells, furrowed, a few trees.
fn field(block: &mut Block, crop: Finish) {
    let cell = 3.0 * block.cell;
    let other = if block.rng.random_bool(0.4) { palette::crop(&mut block.rng) } else { crop };
    let cut = block.rng.random_range(18.0..36.0);
    for (x0, x1, finish) in [(WIDTH, cut, crop), (cut, PITCH, other)] {
        block.floor_cells(Rect::new(x0, x1, WIDTH, PITCH), cell, |i, _| {
            finish.shaded(if i % 2 == 0 { 1.0 } else { 0.93 })
        });
    }
    greenery::grove(block, Rect::new(WIDTH, PITCH, WIDTH, PITCH), 800.0, 5.0..9.0);
}
