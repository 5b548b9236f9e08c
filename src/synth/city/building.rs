//! Buildings: façades of bays with windows, and roofs. A building is made in its own axes about its middle, its front
//! towards -y, its floor at z = 0; the walls end in the ground, wherever that lies.

use glam::{DVec2, DVec3};
use rand::RngExt;

use super::finish::Finish;
use super::palette;
use super::surface::{Block, Spot};
use crate::base::convert::Cut;

/// Height of a roof's covering above the walls, metres: without it covering and walls would mingle.
const COVER: f64 = 0.12;

/// The height that stands for the ground under the wall.
const GROUND: f64 = f64::NEG_INFINITY;

/// The look of a façade.
#[derive(Debug, Clone, Copy)]
pub(super) struct Facade {
    /// The wall.
    pub wall: Finish,
    /// The ground floor's wall.
    pub plinth: Finish,
    /// Width of a bay, metres; each bay has a window.
    pub bay: f64,
    /// Height of a storey, metres.
    pub storey: f64,
    /// Width and height of a window, metres.
    pub window: DVec2,
    /// Height of the sill above the floor, metres.
    pub sill: f64,
    /// Whether the ground floor has shop windows.
    pub shops: bool,
}

/// The shape of a building: half its extents along its own x and y, and its storeys.
#[derive(Debug, Clone, Copy)]
pub(super) struct Body {
    /// Half extents, metres.
    pub half: DVec2,
    /// The number of storeys.
    pub storeys: usize,
}

/// The door of a wall.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Door {
    /// No door.
    No,
    /// A door in the middle bay.
    Middle,
}

/// The four walls. `sides` gives for front, right, back and left the height above which the wall stands free: 0 for a free
/// wall, `None` for a wall that a neighbour hides.
pub(super) fn walls(block: &mut Block, spot: Spot, body: Body, facade: &Facade, sides: [Option<f64>; 4]) {
    let DVec2 { x, y } = body.half;
    let ring = [DVec2::new(-x, -y), DVec2::new(x, -y), DVec2::new(x, y), DVec2::new(-x, y)];
    for (k, free) in sides.into_iter().enumerate() {
        let (from, to) = (ring[k], ring[(k + 1) % 4]);
        let top = body.storeys as f64 * facade.storey;
        match free {
            None => {}
            Some(low) if low > 0.0 => rect(block, spot, from, to, [0.0, from.distance(to), low, top], &facade.wall),
            Some(_) => {
                let door = if k == 0 { Door::Middle } else { Door::No };
                front(block, spot, [from, to], body.storeys, facade, door);
            }
        }
    }
}

/// A wall of bays and storeys.
fn front(block: &mut Block, spot: Spot, [from, to]: [DVec2; 2], storeys: usize, facade: &Facade, door: Door) {
    let length = from.distance(to);
    let bays = usize::cut((length / facade.bay).round()).max(1);
    let bay = length / bays as f64;
    for storey in 0..storeys {
        let (floor, ceiling) = (storey as f64 * facade.storey, (storey + 1) as f64 * facade.storey);
        let (low, wall) = if storey == 0 { (GROUND, &facade.plinth) } else { (floor, &facade.wall) };
        for k in 0..bays {
            let (left, right) = (k as f64 * bay, (k + 1) as f64 * bay);
            let is_door = storey == 0 && door == Door::Middle && k == bays / 2;
            let (size, sill, pane) = if is_door {
                (DVec2::new(1.1, 2.1), GROUND, palette::door(&mut block.rng))
            } else if storey == 0 && facade.shops {
                (DVec2::new(bay - 0.5, facade.storey - 0.9), 0.4, palette::glass(&mut block.rng))
            } else if block.rng.random_bool(0.9) {
                (facade.window, facade.sill, palette::glass(&mut block.rng))
            } else {
                rect(block, spot, from, to, [left, right, low, ceiling], wall);
                continue;
            };
            let (middle, half) = (0.5 * (left + right), 0.5 * size.x.min(bay - 0.3));
            let (a, b) = (middle - half, middle + half);
            let (bottom, top) = (floor + sill, (floor + sill.max(0.0) + size.y).min(ceiling - 0.2));
            rect(block, spot, from, to, [left, a, low, ceiling], wall);
            rect(block, spot, from, to, [b, right, low, ceiling], wall);
            rect(block, spot, from, to, [a, b, top, ceiling], wall);
            rect(block, spot, from, to, [a, b, bottom, top], &pane);
            if bottom > low {
                rect(block, spot, from, to, [a, b, low, bottom], wall);
            }
        }
    }
}

/// A piece of the wall from `from` to `to`: `u0..u1` along it, `z0..z1` in height.
fn rect(block: &mut Block, spot: Spot, from: DVec2, to: DVec2, [u0, u1, z0, z1]: [f64; 4], finish: &Finish) {
    let along = (to - from).normalize();
    let at = |u: f64, z: f64| {
        let at = from + along * u;
        at.extend(if z == GROUND { block.footing(spot, at) } else { z })
    };
    let corners = [at(u0, z0), at(u1, z0), at(u1, z1), at(u0, z1)];
    block.patch(spot, corners, finish);
}

/// A surface that lies in the covering of a pitched roof: a share of the slope's width and height, and a finish.
#[derive(Debug, Clone, Copy)]
pub(super) struct Inlay {
    /// Least and greatest share of the width.
    pub across: [f64; 2],
    /// Least and greatest share of the way up.
    pub up: [f64; 2],
    /// The inlay's finish.
    pub finish: Finish,
}

/// The heights of a pitched roof, metres.
#[derive(Debug, Clone, Copy)]
pub(super) struct Pitch {
    /// Height of the eaves, where the walls end.
    pub eaves: f64,
    /// Height of the ridge above the eaves.
    pub rise: f64,
}

/// A gable roof, its ridge along x. The gables are closed with `wall`; the inlay lies on the front slope.
pub(super) fn gable(
    block: &mut Block,
    spot: Spot,
    half: DVec2,
    Pitch { eaves, rise }: Pitch,
    cover: &Finish,
    wall: &Finish,
    inlay: Option<Inlay>,
) {
    let (over, verge) = (0.45, 0.3);
    let low = eaves + COVER - over * rise / half.y;
    let (x, y, ridge) = (half.x + verge, half.y + over, eaves + COVER + rise);
    let slope = |s: f64| {
        [
            DVec3::new(-x * s, -y * s, low),
            DVec3::new(x * s, -y * s, low),
            DVec3::new(x * s, 0.0, ridge),
            DVec3::new(-x * s, 0.0, ridge),
        ]
    };
    inlaid(block, spot, slope(1.0), cover, inlay);
    block.patch(spot, slope(-1.0), cover);
    for s in [1.0, -1.0] {
        let (x, y) = (half.x * s, half.y * s);
        block.gable(spot, [DVec3::new(x, -y, eaves), DVec3::new(x, y, eaves), DVec3::new(x, 0.0, eaves + rise)], wall);
    }
}

/// A hipped roof; `half.x` must not be less than `half.y`. Over a square the roof is a pyramid.
pub(super) fn hip(block: &mut Block, spot: Spot, half: DVec2, pitch: Pitch, cover: &Finish, inlay: Option<Inlay>) {
    let Pitch { eaves, rise } = pitch;
    let over = 0.45;
    let low = eaves + COVER - over * rise / half.y;
    let (x, y, ridge) = (half.x + over, half.y + over, eaves + COVER + rise);
    let end = half.x - half.y;
    let corner = |s: f64, t: f64| DVec3::new(s * x, t * y, low);
    let peak = |s: f64| DVec3::new(s * end, 0.0, ridge);
    if end < 0.5 {
        let top = DVec3::new(0.0, 0.0, ridge);
        block.gable(spot, [corner(-1.0, -1.0), corner(1.0, -1.0), top], cover);
        block.gable(spot, [corner(1.0, 1.0), corner(-1.0, 1.0), top], cover);
        block.gable(spot, [corner(1.0, -1.0), corner(1.0, 1.0), top], cover);
        block.gable(spot, [corner(-1.0, 1.0), corner(-1.0, -1.0), top], cover);
        return;
    }
    inlaid(block, spot, [corner(-1.0, -1.0), corner(1.0, -1.0), peak(1.0), peak(-1.0)], cover, inlay);
    block.patch(spot, [corner(1.0, 1.0), corner(-1.0, 1.0), peak(-1.0), peak(1.0)], cover);
    block.gable(spot, [corner(1.0, -1.0), corner(1.0, 1.0), peak(1.0)], cover);
    block.gable(spot, [corner(-1.0, 1.0), corner(-1.0, -1.0), peak(-1.0)], cover);
}

/// A slope with an inlay in its covering.
fn inlaid(block: &mut Block, spot: Spot, slope: [DVec3; 4], cover: &Finish, inlay: Option<Inlay>) {
    block.patch_cells(spot, slope, |u, v| match inlay {
        Some(i) if i.across[0] < u && u < i.across[1] && i.up[0] < v && v < i.up[1] => i.finish,
        _ => *cover,
    });
}

/// A flat roof behind a parapet, over walls that end at `top`.
pub(super) fn flat(block: &mut Block, spot: Spot, half: DVec2, top: f64, cover: &Finish, parapet: &Finish) {
    let (width, depth) = (0.35, 0.45);
    let ring = |inset: f64, z: f64| {
        let DVec2 { x, y } = half - inset;
        [DVec3::new(-x, -y, z), DVec3::new(x, -y, z), DVec3::new(x, y, z), DVec3::new(-x, y, z)]
    };
    let (outer, inner, floor) = (ring(0.0, top), ring(width, top), ring(width, top - depth));
    for k in 0..4 {
        let next = (k + 1) % 4;
        block.patch(spot, [outer[k], outer[next], inner[next], inner[k]], parapet);
        block.patch(spot, [inner[k], inner[next], floor[next], floor[k]], parapet);
    }
    block.patch(spot, floor, cover);
    // Lift heads and ventilation.
    let units = usize::cut(half.x * half.y / 16.0);
    for _ in 0..units.clamp(1, 8) {
        let metal = palette::sheet(&mut block.rng);
        let size = DVec2::new(block.rng.random_range(0.5..1.1), block.rng.random_range(0.5..1.1));
        let reach = half - width - size - 0.4;
        let at = DVec2::new(block.rng.random_range(-1.0..1.0), block.rng.random_range(-1.0..1.0)) * reach;
        let high = top - depth + block.rng.random_range(0.7..1.6);
        block.solid(spot, (at - size).extend(top - depth - 0.05), (at + size).extend(high), &metal, &metal);
    }
}

/// A chimney through a roof, from `low` to `high`.
pub(super) fn chimney(block: &mut Block, spot: Spot, at: DVec2, [low, high]: [f64; 2]) {
    let (brick, top) = (palette::brick(&mut block.rng), palette::stone(&mut block.rng));
    block.solid(spot, (at - 0.4).extend(low), (at + 0.4).extend(high), &brick, &top);
}
