//! A block as it is photographed, and as a reconstruction of it is handed out: vertices moved, holes, blobs for trees. What is
//! handed out has the truth of the triangles that it comes from.

use glam::{DVec3, IVec3, Vec3};

use super::noise::{cell, noise, unit};
use super::texture;
use crate::base::convert::to_u32;
use crate::synth::city::finish::Substance;
use crate::synth::city::surface::{Part, Surface};

/// Standard deviation of a vertex, as a share of the edge of the cells: of its own, and shared with those about it.
const OWN: f64 = 0.05;
const SHARED: f64 = 0.08;

/// Length over which vertices are moved alike, metres.
const ALIKE: f32 = 2.5;

/// Edge of the cells that have a hole each, perhaps; its chance; its radius. Metres.
const HOLES: f32 = 6.0;
const CHANCE: f32 = 0.15;
const RADIUS: [f32; 2] = [0.4, 1.3];

/// The town's part of a block, with materials before any texture.
pub(in crate::synth::city) fn town(block: &Surface) -> Surface {
    part(block, |t| block.parts[t] != Part::Mesh)
}

/// The part of a block that is handed out, with its truth; `edge` is that of the block's cells, metres.
pub(in crate::synth::city) fn given(block: &Surface, edge: f64) -> Surface {
    let corners = |t: usize| block.triangles[t].map(|v| block.vertices[v as usize].as_vec3());
    let mut kept = part(block, |t| block.parts[t] != Part::Town && !is_lost(block.substances[t], corners(t)));
    let whole = |t: usize| kept.triangles[t].map(|v| kept.vertices[v as usize].as_vec3());
    let truth = |t: usize| texture::mean(kept.substances[t], &kept.materials[t], whole(t));
    kept.materials = (0..kept.triangles.len()).map(truth).collect();
    kept.vertices.iter_mut().for_each(|v| *v += moved(*v) * edge.min(2.0));
    kept
}

/// The triangles of a block that are wanted, and their vertices.
fn part(block: &Surface, is_wanted: impl Fn(usize) -> bool) -> Surface {
    let mut number = vec![u32::MAX; block.vertices.len()];
    let mut kept = Surface::default();
    for t in (0..block.triangles.len()).filter(|t| is_wanted(*t)) {
        let corners = block.triangles[t].map(|v| {
            let number = &mut number[v as usize];
            if *number == u32::MAX {
                *number = to_u32(kept.vertices.len());
                kept.vertices.push(block.vertices[v as usize]);
            }
            *number
        });
        kept.triangles.push(corners);
        kept.materials.push(block.materials[t]);
        kept.substances.push(block.substances[t]);
        kept.parts.push(block.parts[t]);
    }
    kept
}

/// How far a vertex is moved, in edges of cells. Vertices in one place, to the millimetre, stay in one.
fn moved(at: DVec3) -> DVec3 {
    let place = (at * 1000.0).round().as_ivec3();
    let near = at.as_vec3() / ALIKE;
    let axis = |k: u32| {
        // The sum of three even numbers is near a normal one, of a deviation of a half.
        let own: f32 = (0..3).map(|n| unit(place, 100 + 3 * k + n)).sum::<f32>() - 1.5;
        2.0 * OWN * f64::from(own) + 2.5 * SHARED * f64::from(noise(near, 110 + k))
    };
    DVec3::new(axis(0), axis(1), axis(2))
}

/// Whether a reconstruction has a hole where a triangle was: here and there, and often in what mirrors.
fn is_lost(substance: Substance, [a, b, c]: [Vec3; 3]) -> bool {
    let middle = (a + b + c) / 3.0;
    if substance.is_clear() && noise(middle / 1.5, 120) > 0.3 {
        return true;
    }
    let home = cell(middle / HOLES);
    let near = (0..27).map(|k| home + IVec3::new(k % 3 - 1, k / 3 % 3 - 1, k / 9 - 1));
    near.filter(|cell| unit(*cell, 121) < CHANCE).any(|cell| {
        let within = Vec3::new(unit(cell, 122), unit(cell, 123), unit(cell, 124));
        let [low, high] = RADIUS;
        let radius = low + (high - low) * unit(cell, 125);
        ((cell.as_vec3() + within) * HOLES).distance(middle) < radius
    })
}
