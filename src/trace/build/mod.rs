//! Building, in parts: the triangles are split in space into parts of at most 2^18, obvhs groups those of one part after
//! the other into a tree, and a few nodes above the parts join them. Only one part is ever being built, so that building
//! takes little more than the mesh, however large it is.
//!
//! The parts are a function of the mesh alone, and so is every byte of the tree. Nodes can leave as they are made
//! ([`Parts::nodes`]), and the triangles in the order of the leaves after them ([`Ordered::triangles`]): neither need be
//! held.

mod cluster;
mod layout;
mod split;

use std::convert::Infallible;

use glam::Vec3;

use super::Bvh;
use super::ray::scale_below_one;
use super::slab::{Node, WIDTH};
use super::triangle::Packed;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use layout::Layout;

/// Triangles of a part, at most.
pub const PART: usize = 1 << 18;

/// Levels kept for the nodes above the parts: at most 2^15 parts hold 2^32 triangles, and each level halves them.
const ABOVE: usize = 16;

/// A mesh whose triangles are split into parts.
pub struct Parts<'m> {
    mesh: &'m Mesh,
    /// The triangles that have an area, part after part.
    ids: Vec<TriangleId>,
    /// Where each part ends in `ids`.
    ends: Vec<usize>,
    scale: f64,
}

/// A tree whose nodes have been made.
pub struct Ordered<'m> {
    mesh: &'m Mesh,
    /// The triangles in the order of the leaves.
    ids: Vec<TriangleId>,
    scale: f64,
    root: u32,
}

/// A subtree that has been laid out: what its parent says of it.
#[derive(Debug, Clone, Copy)]
struct Slot {
    low: Vec3,
    high: Vec3,
    child: u32,
    count: u8,
}

impl Bvh {
    /// Builds the tree over a mesh's triangles, those without area left out. One thread; the result is a function of
    /// the mesh alone.
    pub fn build(mesh: &Mesh) -> Bvh {
        Bvh::build_in_parts(mesh, PART)
    }

    /// Builds the tree from parts of at most so many triangles.
    pub(super) fn build_in_parts(mesh: &Mesh, most: usize) -> Bvh {
        let mut nodes = Vec::new();
        let made = Parts::at_most(most, mesh).make(&mut |some: &[Node]| {
            nodes.extend_from_slice(some);
            Ok::<(), Infallible>(())
        });
        let Ok(ordered) = made;
        nodes.shrink_to_fit();
        let triangles: Vec<Packed> = ordered.packed().collect();
        let Ordered { root, scale, .. } = ordered;
        Bvh { nodes: nodes.into(), triangles: triangles.into(), root, scale }
    }
}

impl<'m> Parts<'m> {
    /// Bytes of memory per triangle that splitting takes, and then ordering.
    pub const BYTES_PER_TRIANGLE: u64 = 16;

    /// Bytes of memory that building one part takes besides: obvhs holds about 200 a triangle.
    pub const BYTES: u64 = 256 * PART as u64;

    /// Splits the triangles of a mesh, those without area left out.
    pub fn of(mesh: &'m Mesh) -> Self {
        Parts::at_most(PART, mesh)
    }

    fn at_most(most: usize, mesh: &'m Mesh) -> Self {
        let (mut size, mut count) = (0f32, 0);
        for t in (0..mesh.len() as TriangleId).filter(|&t| mesh.normal(t).is_some()) {
            size = mesh.corners(t).into_iter().fold(size, |m, p| m.max(p.abs().max_element()));
            count += 1;
        }
        let (ids, ends) = split::split(mesh, count, most);
        Parts { mesh, ids, ends, scale: if count == 0 { 1.0 } else { scale_below_one(size) } }
    }

    /// Makes the nodes, and writes them as they are made: as [`Bvh::view`] wants them.
    ///
    /// # Errors
    /// Those of `put`.
    pub fn nodes<E>(self, put: &mut dyn FnMut(&[u8]) -> Result<(), E>) -> Result<Ordered<'m>, E> {
        self.make(&mut |some: &[Node]| put(bytemuck::cast_slice(some)))
    }

    fn make<E>(mut self, put: &mut dyn FnMut(&[Node]) -> Result<(), E>) -> Result<Ordered<'m>, E> {
        let mut slots = Vec::with_capacity(self.ends.len());
        let (mut made, mut start) = (0, 0);
        let depth = if self.ends.len() > 1 { ABOVE } else { 0 };
        for &end in &self.ends {
            let part = &mut self.ids[start..end];
            let layout = Layout::of(self.mesh, part, self.scale, depth, (made, start as u32));
            slots.push(layout.slot);
            part.copy_from_slice(&layout.order);
            put(&layout.nodes)?;
            made += layout.nodes.len() as u32;
            start = end;
        }
        let mut above = Vec::new();
        let root = join(&slots, made, &mut above).map_or(0, |slot| slot.child);
        put(&above)?;
        Ok(Ordered { mesh: self.mesh, ids: self.ids, scale: self.scale, root })
    }
}

impl Ordered<'_> {
    /// The node that the tree begins with.
    pub fn root(&self) -> u32 {
        self.root
    }

    /// The power of two that coordinates are multiplied by.
    pub fn scale(&self) -> f64 {
        self.scale
    }

    /// Triangles without area: they are in no leaf.
    pub fn left_out(&self) -> u64 {
        (self.mesh.len() - self.ids.len()) as u64
    }

    /// Writes the triangles in the order of the leaves, a few at a time: as [`Bvh::view`] wants them.
    ///
    /// # Errors
    /// Those of `put`.
    pub fn triangles<E>(&self, put: &mut dyn FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
        let mut all = self.packed();
        let mut some: Vec<Packed> = Vec::new();
        loop {
            some.clear();
            some.extend(all.by_ref().take(1024));
            if some.is_empty() {
                return Ok(());
            }
            put(bytemuck::cast_slice(&some))?;
        }
    }

    fn packed(&self) -> impl ExactSizeIterator<Item = Packed> {
        let pack = |&id: &TriangleId| Packed { corners: scaled(self.mesh, id, self.scale).map(|p| p.to_array()), id };
        self.ids.iter().map(pack)
    }
}

/// A triangle's corners in scaled coordinates.
fn scaled(mesh: &Mesh, id: TriangleId, scale: f64) -> [Vec3; 3] {
    mesh.corners(id).map(|p| (p.as_dvec3() * scale).as_vec3())
}

/// Joins the roots of parts, which lie in space as they lie in the list: halves of it, and halves of these, are apart. A
/// node opens the largest of its halves until it is full. Children come before their parents; `first` is the number of
/// the first node. `None` if there are no parts.
fn join(parts: &[Slot], first: u32, nodes: &mut Vec<Node>) -> Option<Slot> {
    if let [] | [_] = parts {
        return parts.first().copied();
    }
    let area = |list: &[Slot]| {
        let (low, high) = bounds(list);
        let d = high - low;
        d.x * d.y + d.y * d.z + d.z * d.x
    };
    let mut children = vec![parts];
    while children.len() < WIDTH {
        let open = children.iter().enumerate().filter(|(_, list)| list.len() > 1);
        let Some((widest, _)) = open.max_by(|a, b| area(a.1).total_cmp(&area(b.1))) else { break };
        let (left, right) = children[widest].split_at(children[widest].len() / 2);
        children[widest] = left;
        children.insert(widest + 1, right);
    }
    let mut node = Node::VACANT;
    for (i, list) in children.into_iter().enumerate() {
        node.set(i, &join(list, first, nodes)?);
    }
    nodes.push(node);
    let (low, high) = bounds(parts);
    Some(Slot { low, high, child: first + nodes.len() as u32 - 1, count: 0 })
}

fn bounds(slots: &[Slot]) -> (Vec3, Vec3) {
    let start = (Vec3::INFINITY, Vec3::NEG_INFINITY);
    slots.iter().fold(start, |(low, high), slot| (low.min(slot.low), high.max(slot.high)))
}

impl Node {
    /// Says of the child in this place where it is and what box holds it.
    fn set(&mut self, i: usize, slot: &Slot) {
        for axis in 0..3 {
            self.low[axis][i] = slot.low[axis];
            self.high[axis][i] = slot.high[axis];
        }
        self.child[i] = slot.child;
        self.count[i] = slot.count;
    }
}
