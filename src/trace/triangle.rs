//! The watertight triangle test of Woop, Benthin and Wald (JCGT 2(1), 2013), with every hit's weights in f64.
//!
//! Corners are moved to the ray's origin and sheared so that the ray is the z axis; that rounds, but each corner for
//! itself, so triangles that share a corner still share it. What is left is whether the 2D point 0 lies in a 2D triangle:
//! three differences of two f32 products. An f32 difference of rounded products that is not zero has the exact sign,
//! since rounding keeps order; that sorts out most triangles. For the rest the products are taken in f64, where they are
//! exact: the signs are then those of exact arithmetic, so that what one side of an edge lets pass the other side holds;
//! and the weights, hence t, u and v, are right to a few units in the last place of an f64 however thin the triangle.

use bytemuck::{Pod, Zeroable};

use super::ray::Course;
use crate::base::convert::to_f32;
use crate::base::ids::TriangleId;

/// A triangle as leaves hold it, in scaled coordinates: 40 bytes.
#[derive(Debug, Clone, Copy, Pod, Zeroable)]
#[repr(C)]
pub(super) struct Packed {
    /// Vertices 0, 1, 2.
    pub corners: [[f32; 3]; 3],
    /// The triangle's position in the file.
    pub id: TriangleId,
}

/// Where a ray meets a triangle: `t` along the scaled direction, in scaled coordinates.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Meeting {
    pub t: f32,
    pub u: f32,
    pub v: f32,
}

/// The sheared corners: x, y and z of vertices 0, 1, 2.
pub(super) type Sheared = [[f32; 3]; 3];

/// The three edge functions in f32. Where two have strictly opposite signs, the ray passes by.
#[inline(always)]
pub(super) fn edges([a, b, c]: [[f32; 2]; 3]) -> [f32; 3] {
    [c[0] * b[1] - c[1] * b[0], a[0] * c[1] - a[1] * c[0], b[0] * a[1] - b[1] * a[0]]
}

/// Whether the edge functions lack a common sign.
#[inline(always)]
pub(super) fn passes_by([u, v, w]: [f32; 3]) -> bool {
    ((u < 0.0) | (v < 0.0) | (w < 0.0)) & ((u > 0.0) | (v > 0.0) | (w > 0.0))
}

/// The meeting of a ray with a triangle that [`passes_by`] did not sort out; `t` is finite and above 0.
#[inline]
pub(super) fn meet([a, b, c]: Sheared, depth: f32) -> Option<Meeting> {
    let [a, b, c] = [a, b, c].map(|p| p.map(f64::from));
    let u = c[0] * b[1] - c[1] * b[0];
    let v = a[0] * c[1] - a[1] * c[0];
    let w = b[0] * a[1] - b[1] * a[0];
    if (u < 0.0 || v < 0.0 || w < 0.0) && (u > 0.0 || v > 0.0 || w > 0.0) {
        return None;
    }
    let sum = u + v + w;
    let t = to_f32((u * a[2] + v * b[2] + w * c[2]) / sum / f64::from(depth));
    // A ray in the triangle's plane has sum = 0, so that t is no number, and misses.
    (t > 0.0 && t < f32::INFINITY).then(|| Meeting { t, u: to_f32(v / sum), v: to_f32(w / sum) })
}

/// The meeting of one ray with one triangle.
#[inline]
pub(super) fn intersect(packed: &Packed, origin: &[f32; 3], course: &Course) -> Option<Meeting> {
    let [x, y, z] = course.axes;
    let sheared = packed.corners.map(|p| {
        let depth = p[z] - origin[z];
        [p[x] - origin[x] - course.shear[0] * depth, p[y] - origin[y] - course.shear[1] * depth, depth]
    });
    if passes_by(edges(sheared.map(|p| [p[0], p[1]]))) { None } else { meet(sheared, course.depth) }
}
