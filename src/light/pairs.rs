//! Pairs of patches that may well have the same albedo: near each other, of like colour, and of like tilt, since what lies flat
//! and what stands is seldom made of the same.

use glam::{IVec3, Vec3};
use rayon::prelude::*;

use super::draw::draw;
use super::patches::{Patch, Patches};
use crate::base::convert::to_u32;

/// Partners of a patch: half of them those whose normals differ most, half drawn.
const PARTNERS: usize = 12;
/// The nearest patches that partners are taken from.
const POOL: usize = 64;
/// What counts as one unit of distance: spacings in space, logarithms of chroma, cosines of tilt.
const NEAR: f32 = 3.0;
const CHROMA: f32 = 0.25;
const TILT: f32 = 0.1;
/// The largest distance of partners.
const FARTHEST: f32 = 1.5;
/// Radiance that is added before logarithms are taken.
const DIM: f32 = 0.003;

/// Two patches, the lower position first.
pub(super) type Pair = [u32; 2];

/// A patch's place among those that it may be like.
#[derive(Debug, Clone, Copy)]
struct Place {
    at: Vec3,
    chroma: Vec3,
    tilt: f32,
}

impl Place {
    fn of(patch: &Patch, patches: &Patches<'_>) -> Place {
        let log = Vec3::from_array(patch.radiance.map(|v| (v + DIM).ln()));
        Place {
            at: patch.middle / (NEAR * patches.spacing.max(f32::MIN_POSITIVE)),
            chroma: (log - log.element_sum() / 3.0) / CHROMA,
            tilt: Vec3::from(patch.normal).dot(patches.up) / TILT,
        }
    }

    fn distance2(&self, other: &Place) -> f32 {
        self.at.distance_squared(other.at)
            + self.chroma.distance_squared(other.chroma)
            + (self.tilt - other.tilt).powi(2)
    }

    /// The cell of space that the patch lies in; partners lie in the same one or beside it.
    fn cell(&self) -> IVec3 {
        (self.at / FARTHEST).floor().as_ivec3()
    }
}

/// The pairs, ascending, each once.
pub(super) fn pairs(patches: &Patches<'_>) -> Vec<Pair> {
    let places: Vec<Place> = patches.all.iter().map(|patch| Place::of(patch, patches)).collect();
    let key = |cell: IVec3| [cell.z, cell.y, cell.x];
    let mut cells: Vec<([i32; 3], u32)> =
        places.iter().enumerate().map(|(i, place)| (key(place.cell()), to_u32(i))).collect();
    cells.sort_unstable();
    let partners = |(i, place): (usize, &Place)| {
        let mut near: Vec<(f32, u32)> = Vec::new();
        for row in 0..9 {
            let row = place.cell() + IVec3::new(-1, row % 3 - 1, row / 3 - 1);
            // Cells that follow one another along x are one range of the list.
            let from = cells.partition_point(|(cell, _)| *cell < key(row));
            let to = cells.partition_point(|(cell, _)| *cell <= key(row + 2 * IVec3::X));
            near.extend(cells[from..to].iter().filter(|(_, j)| *j as usize != i).filter_map(|(_, j)| {
                let distance = place.distance2(&places[*j as usize]);
                (distance < FARTHEST * FARTHEST).then_some((distance, *j))
            }));
        }
        near.sort_unstable_by(|a, b| a.0.total_cmp(&b.0).then(a.1.cmp(&b.1)));
        near.truncate(POOL);
        let normal = patches.all[i].normal;
        let like = |j: u32| normal.dot(patches.all[j as usize].normal);
        let mut chosen: Vec<u32> = near.iter().map(|(_, j)| *j).collect();
        let mut drawn = chosen.clone();
        chosen.sort_by(|a, b| like(*a).total_cmp(&like(*b)));
        chosen.truncate(PARTNERS / 2);
        drawn.sort_by_key(|j| draw(i as u64, u64::from(*j)));
        chosen.extend(&drawn[..drawn.len().min(PARTNERS - PARTNERS / 2)]);
        chosen.into_iter().map(|j| [to_u32(i).min(j), to_u32(i).max(j)]).collect::<Vec<Pair>>()
    };
    let of_each: Vec<Vec<Pair>> = places.par_iter().enumerate().map(partners).collect();
    let mut all = of_each.concat();
    all.sort_unstable();
    all.dedup();
    all
}
