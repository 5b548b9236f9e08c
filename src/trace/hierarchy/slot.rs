//! What a node says of each of its children.

use glam::Vec3;

use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::trace::slab::Node;

/// A subtree that has been laid out: its box and its place.
#[derive(Debug, Clone, Copy)]
pub(super) struct Slot {
    /// Lower corner of the box.
    pub low: Vec3,
    /// Upper corner of the box.
    pub high: Vec3,
    /// The subtree's first node, or the leaf's first triangle.
    pub child: u32,
    /// Triangles of the leaf; 0 for a node.
    pub count: u8,
}

impl Node {
    /// Sets the child at position `i`.
    pub(super) fn set(&mut self, i: usize, slot: &Slot) {
        for axis in 0..3 {
            self.low[axis][i] = slot.low[axis];
            self.high[axis][i] = slot.high[axis];
        }
        self.child[i] = slot.child;
        self.count[i] = slot.count;
    }
}

/// A triangle's corners in scaled coordinates.
pub(super) fn scaled(mesh: &Mesh, id: TriangleId, scale: f64) -> [Vec3; 3] {
    mesh.corners(id).map(|p| (p.as_dvec3() * scale).as_vec3())
}
