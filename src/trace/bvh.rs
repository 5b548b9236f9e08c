//! The tree, and its traversal by one ray.

use super::ray::{Course, Hit, Ray};
use super::slab::{EMPTY, Node, WIDTH, larger, smaller};
use super::triangle::{Meeting, Packed, intersect};
use crate::base::Array;
use crate::base::convert::to_f32;
use crate::base::ids::TriangleId;

/// A bounding volume hierarchy, four boxes to a node, over copies of the triangles. Built by [`Bvh::build`](Bvh::build).
#[derive(Debug, Clone)]
pub struct Bvh {
    /// The nodes; none if there is nothing to hit.
    pub(super) nodes: Array<Node>,
    /// The triangles in the order of the leaves.
    pub(super) triangles: Array<Packed>,
    /// The number of the root node.
    pub(super) root: u32,
    /// The power of two that coordinates were multiplied by.
    pub(super) scale: f64,
}

/// Nodes between the root and the farthest leaf, at most; `hierarchy` sees to it.
pub(super) const DEPTH: usize = 56;

/// Entries of the stack: each level leaves all but one child on it.
pub(super) const STACK: usize = (WIDTH - 1) * DEPTH + 1;

/// Scaled origins farther out meet nothing: nearer ones overflow nothing.
const FARTHEST: f32 = (1u128 << 96) as f32;

impl Bvh {
    /// Number of triangles that can be hit.
    pub fn len(&self) -> usize {
        self.triangles.len()
    }

    /// Whether nothing can be hit.
    pub fn is_empty(&self) -> bool {
        self.triangles.is_empty()
    }

    /// Bytes that a tree takes per triangle, at most.
    pub const BYTES_PER_TRIANGLE: u64 = 96;

    /// Bytes that the tree takes, in memory or in a mapped file.
    pub fn bytes(&self) -> u64 {
        (size_of_val(&self.nodes[..]) + size_of_val(&self.triangles[..])) as u64
    }

    /// Bytes of memory that the tree holds: none where it lies in a mapped file.
    pub fn held(&self) -> u64 {
        self.nodes.held() + self.triangles.held()
    }

    /// The nearest triangle at a distance in (0, `t_max`], in lengths of the ray's direction; the triangle with the lower
    /// id where two are equally near.
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
        let origin = origin.to_array().map(|c| to_f32(f64::from(c) * self.scale));
        origin.iter().all(|c| c.abs() < FARTHEST).then_some(origin)
    }

    fn traverse<const ANY: bool>(&self, ray: &Ray, t_max: f32) -> Option<Hit> {
        let (origin, course) = (self.scaled(ray.origin)?, Course::new(ray.direction)?);
        if self.is_empty() {
            return None;
        }
        let unit = course.unit / self.scale;
        let mut best = Best { t: to_f32(f64::from(t_max) / unit), ..Best::NONE };
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
    pub triangle: TriangleId,
    pub u: f32,
    pub v: f32,
}

impl Best {
    /// No meeting yet, and no distance is too far.
    pub(super) const NONE: Best = Best { t: f32::INFINITY, triangle: TriangleId::NONE, u: 0.0, v: 0.0 };

    /// Whether the ray has met a triangle.
    pub(super) fn is_some(&self) -> bool {
        self.triangle != TriangleId::NONE
    }

    /// Takes a meeting that is nearer, or as near with a lower id.
    #[inline]
    pub(super) fn offer(&mut self, triangle: TriangleId, meeting: Meeting) {
        if meeting.t < self.t || (meeting.t == self.t && triangle < self.triangle) {
            *self = Best { t: meeting.t, triangle, u: meeting.u, v: meeting.v };
        }
    }

    /// The hit; `unit` is a unit of scaled distance in lengths of the ray's direction.
    #[inline]
    pub(super) fn hit(&self, unit: f64) -> Hit {
        Hit { triangle: self.triangle, t: to_f32(f64::from(self.t) * unit), u: self.u, v: self.v }
    }
}

/// The distance at which the ray enters each box; NaN where it does not enter before `t_max`.
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
