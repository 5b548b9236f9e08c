//! The triangles in chunks, the nodes that are made of them chunk by chunk, and the order of the leaves.

use std::convert::Infallible;

use super::above::join;
use super::layout::{Before, Layout};
use super::slot::scaled;
use super::split::{Split, split};
use crate::base::convert::to_u32;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::trace::bvh::Bvh;
use crate::trace::ray::scale_below_one;
use crate::trace::slab::Node;
use crate::trace::triangle::Packed;

/// Triangles of a chunk, at most.
pub(crate) const CHUNK: usize = 1 << 18;

/// Levels kept for the nodes above the chunks: at most 2^15 chunks hold 2^32 triangles, and each level halves them.
const ABOVE: usize = 16;

/// A mesh whose triangles are split into chunks.
pub(crate) struct Chunks<'m> {
    mesh: &'m Mesh,
    /// The triangles that have an area.
    split: Split,
    scale: f64,
}

/// A tree whose nodes have been made.
pub(crate) struct Ordered<'m> {
    mesh: &'m Mesh,
    /// The triangles in the order of the leaves.
    ids: Vec<TriangleId>,
    scale: f64,
    root: u32,
}

impl Bvh {
    /// Builds the tree over a mesh's triangles; triangles without area are left out. Runs on one thread; the result is a
    /// function of the mesh alone.
    pub fn build(mesh: &Mesh) -> Bvh {
        Bvh::build_in_chunks(mesh, CHUNK)
    }

    /// Builds the tree from chunks of at most so many triangles.
    pub(in crate::trace) fn build_in_chunks(mesh: &Mesh, most: usize) -> Bvh {
        let mut nodes = Vec::new();
        let made = Chunks::at_most(most, mesh).make(&mut |some: &[Node]| {
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

impl<'m> Chunks<'m> {
    /// Bytes of memory per triangle that splitting takes, and afterwards ordering.
    pub(crate) const BYTES_PER_TRIANGLE: u64 = 16;

    /// Bytes of memory that building one chunk takes besides: obvhs holds about 200 a triangle.
    pub(crate) const BYTES: u64 = 256 * CHUNK as u64;

    /// Splits the triangles of a mesh; triangles without area are left out.
    pub(crate) fn of(mesh: &'m Mesh) -> Self {
        Chunks::at_most(CHUNK, mesh)
    }

    fn at_most(most: usize, mesh: &'m Mesh) -> Self {
        let (mut size, mut count) = (0f32, 0);
        for t in TriangleId::all(mesh.len()).filter(|&t| mesh.normal(t).is_some()) {
            size = mesh.corners(t).into_iter().fold(size, |m, p| m.max(p.abs().max_element()));
            count += 1;
        }
        let split = split(mesh, count, most);
        Chunks { mesh, split, scale: if count == 0 { 1.0 } else { scale_below_one(size) } }
    }

    /// Makes the nodes and writes them as they are made, in the form that [`Bvh::view`] reads.
    ///
    /// # Errors
    /// Those of `put`.
    pub(crate) fn nodes<E>(self, put: &mut dyn FnMut(&[u8]) -> Result<(), E>) -> Result<Ordered<'m>, E> {
        self.make(&mut |some: &[Node]| put(bytemuck::cast_slice(some)))
    }

    fn make<E>(mut self, put: &mut dyn FnMut(&[Node]) -> Result<(), E>) -> Result<Ordered<'m>, E> {
        let Split { ids, ends } = &mut self.split;
        let mut slots = Vec::with_capacity(ends.len());
        let (mut made, mut start) = (0, 0);
        let depth = if ends.len() > 1 { ABOVE } else { 0 };
        for &end in &*ends {
            let chunk = &mut ids[start..end];
            let before = Before { nodes: made, triangles: to_u32(start) };
            let layout = Layout::of(self.mesh, chunk, self.scale, depth, before);
            slots.push(layout.slot);
            chunk.copy_from_slice(&layout.order);
            put(&layout.nodes)?;
            made += to_u32(layout.nodes.len());
            start = end;
        }
        let mut above = Vec::new();
        let root = join(&slots, made, &mut above).map_or(0, |slot| slot.child);
        put(&above)?;
        Ok(Ordered { mesh: self.mesh, ids: self.split.ids, scale: self.scale, root })
    }
}

impl Ordered<'_> {
    /// The number of the root node.
    pub(crate) fn root(&self) -> u32 {
        self.root
    }

    /// The power of two that coordinates are multiplied by.
    pub(crate) fn scale(&self) -> f64 {
        self.scale
    }

    /// Number of triangles without area: they are in no leaf.
    pub(crate) fn left_out(&self) -> u64 {
        (self.mesh.len() - self.ids.len()) as u64
    }

    /// Writes the triangles in the order of the leaves, a few at a time, in the form that [`Bvh::view`] reads.
    ///
    /// # Errors
    /// Those of `put`.
    pub(crate) fn triangles<E>(&self, put: &mut dyn FnMut(&[u8]) -> Result<(), E>) -> Result<(), E> {
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
