//! The tree, and its traversal by one ray.

use super::ray::{Course, Hit, Ray};
use super::slab::{EMPTY, Node, WIDTH, larger, smaller};
use super::triangle::{Packed, intersect};
use crate::base::Array;
use crate::base::ids::NO_TRIANGLE;

/// A bounding volume hierarchy, four boxes to a node, over copies of the triangles. Built by [`Bvh::build`](Bvh::build).
#[derive(Debug, Clone)]
pub struct Bvh {
    /// None if there is nothing to hit.
    pub(super) nodes: Array<Node>,
    /// In the order of the leaves.
    pub(super) triangles: Array<Packed>,
    /// The node that all others are below.
    pub(super) root: u32,
    /// The power of two that coordinates were multiplied by.
    pub(super) scale: f64,
}

/// Nodes between the root and the farthest leaf, at most; `build` sees to it.
pub(super) const DEPTH: usize = 56;

/// Each level leaves all but one child on the stack.
pub(super) const STACK: usize = (WIDTH - 1) * DEPTH + 1;

/// Scaled origins farther out meet nothing: nothing overflows this side of it.
const FARTHEST: f32 = (1u128 << 96) as f32;

impl Bvh {
    /// Triangles that can be hit.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether nothing can be hit.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Bytes that it takes per triangle, at most.
    pub const BYTES_PER_TRIANGLE: u64 = 96;

    /// Bytes that it takes, wherever they are.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.nodes[..]) + size_of_val(&self.triangles[..])) as u64
    }

    /// Bytes of memory that it holds: none where it lies in a mapped file.
    pub fn held(&self) -> u64 {
        self.nodes.held() + self.triangles.held()
    }

    /// The nearest triangle at a distance in (0, `t_max`], in lengths of the ray's direction; the one with the lower id
    /// where two are equally near.
    pub fn nearest(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        self.traverse::<false>(ray, t_max)
    }

    /// Whether any triangle is hit at a distance in (0, `t_max`].
    pub fn occluded(&self, ray: &Ray, t_max: f32) -> bool {
        self.traverse::<true>(ray, t_max).is_some()
    }

    /// The origin in scaled coordinates; `None` if it is too far away or not finite.
    #[inline]
    pub(super) fn scaled(&self, origin: glam::Vec3) -> Option<[f32; 3]> {
        let origin = origin.to_array().map(|c| (f64::from(c) * self.scale) as f32);
        origin.iter().all(|c| c.abs() < FARTHEST).then_some(origin)
    }

    fn traverse<const ANY: bool>(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        let (origin, course) = (self.scaled(ray.origin)?, Course::new(ray.direction)?);
        if self.is_empty() {
            return None;
        }
        let unit = course.unit / self.scale;
        let mut best = Best { t: (f64::from(t_max) / unit) as f32, ..Best::NONE };
        let (nodes, triangles): (&[Node], &[Packed]) = (&self.nodes, &self.triangles);
        let mut stack = [(0f32, self.root); STACK];
        let mut held = 1;
        while held > 0 {
            held -= 1;
            let (entry, node) = stack[held];
            if entry > best.t {
                continue;
            }
            let node = &nodes[node as usize];
            let entries = enter(node, &origin, &course, best.t);
            let from = held;
            for (i, &entry) in entries.iter().enumerate() {
                if node.count[i] == EMPTY || entry.is_nan() || entry > best.t {
                    continue;
                }
                if node.count[i] == 0 {
                    stack[held] = (entry, node.child[i]);
                    held += 1;
                    continue;
                }
                for packed in leaf(triangles, node, i) {
                    let Some(meeting) = intersect(packed, &origin, &course) else { continue };
                    best.offer(packed.id, meeting);
                    if ANY && best.is_some() {
                        return Some(best.hit(unit));
                    }
                }
            }
            // Nearest on top.
            stack[from..held].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        }
        best.is_some().then(|| best.hit(unit))
    }
}

/// The triangles of a leaf.
#[inline(always)]
pub(super) fn leaf<'a>(triangles: &'a [Packed], node: &Node, i: usize) -> &'a [Packed] {
    let first = node.child[i] as usize;
    &triangles[first..first + usize::from(node.count[i])]
}

/// The nearest meeting so far.
#[derive(Debug, Clone, Copy)]
pub(super) struct Best {
    pub t: f32,
    pub triangle: u32,
    pub u: f32,
    pub v: f32,
}

impl Best {
    /// Nothing yet, and nothing is too far.
    pub const NONE: Best = Best { t: f32::INFINITY, triangle: NO_TRIANGLE, u: 0.0, v: 0.0 };

    /// Whether there is one.
    pub fn is_some(&self) -> bool {
        self.triangle != NO_TRIANGLE
    }

    /// Takes a meeting if it is nearer, or as near with a lower id.
    #[inline]
    pub fn offer(&mut self, triangle: u32, meeting: super::triangle::Meeting) {
        if meeting.t < self.t || (meeting.t == self.t && triangle < self.triangle) {
            *self = Best { t: meeting.t, triangle, u: meeting.u, v: meeting.v };
        }
    }

    /// The hit; `unit` is what a scaled distance is in lengths of the ray's direction.
    #[inline]
    pub fn hit(&self, unit: f64) -> Hit {
        Hit { triangle: self.triangle, t: (f64::from(self.t) * unit) as f32, u: self.u, v: self.v }
    }
}

/// Where the ray enters each box; no number where it does not before `t_max`.
#[inline(always)]
fn enter(node: &Node, origin: &[f32; 3], course: &Course, t_max: f32) -> [f32; WIDTH] {
    let [near, far] = node.planes(origin, course.signs);
    let mut entry = [0f32; WIDTH];
    let mut exit = [t_max; WIDTH];
    for axis in 0..3 {
        for i in 0..WIDTH {
            entry[i] = larger(near[axis][i] * course.inverse[axis], entry[i]);
            exit[i] = smaller(far[axis][i] * course.inverse[axis], exit[i]);
        }
    }
    for i in 0..WIDTH {
        entry[i] = if entry[i] <= exit[i] { entry[i] } else { f32::NAN };
    }
    entry
}
