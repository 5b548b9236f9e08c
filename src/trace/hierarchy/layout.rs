//! Lays out the nodes over a chunk's triangles, four children each, from obvhs' binary tree.
//!
//! Subtrees deeper than traversal can hold are laid out anew, balanced.

use glam::Vec3;
use obvhs::bvh2::Bvh2;

use super::cluster::{LEAF, cluster};
use super::slot::{Slot, scaled};
use crate::base::convert::{to_u8, to_u32};
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::trace::bvh::DEPTH;
use crate::trace::slab::{Node, WIDTH};

/// From this depth on a subtree is laid out balanced: that takes at most 16 levels of four for 2^32 triangles.
const BALANCE: usize = DEPTH - 16;

/// A chunk that has been laid out.
pub(super) struct Layout {
    /// The chunk's nodes.
    pub nodes: Vec<Node>,
    /// The chunk's triangles in the order of the leaves.
    pub order: Vec<TriangleId>,
    /// What the node above says of the chunk; its child is a node even if all triangles would fit a leaf.
    pub slot: Slot,
}

/// Numbers of nodes and triangles before a chunk.
#[derive(Debug, Clone, Copy)]
pub(super) struct Before {
    /// Nodes of the chunks before.
    pub nodes: u32,
    /// Triangles of the chunks before.
    pub triangles: u32,
}

/// A subtree still to be laid out.
#[derive(Clone, Copy)]
enum Subtree<'a> {
    /// A node of obvhs' tree.
    Tree(u32),
    /// Triangles (positions in `ids`), halved by their order.
    List(&'a [u32]),
}

/// A chunk that is being laid out.
struct Layer<'a> {
    mesh: &'a Mesh,
    ids: &'a [TriangleId],
    tree: &'a Bvh2,
    nodes: Vec<Node>,
    order: Vec<TriangleId>,
    scale: f64,
    before: Before,
}

impl Layout {
    /// Lays out the triangles `ids`, none of them without area, `depth` levels below the root.
    pub(super) fn of(mesh: &Mesh, ids: &[TriangleId], scale: f64, depth: usize, before: Before) -> Layout {
        let tree = &cluster(mesh, ids, scale);
        let order = Vec::with_capacity(ids.len());
        let mut layer = Layer { mesh, ids, tree, nodes: Vec::new(), order, scale, before };
        let slot = layer.root(depth);
        Layout { nodes: layer.nodes, order: layer.order, slot }
    }
}

impl<'a> Layer<'a> {
    /// Lays out everything.
    fn root(&mut self, depth: usize) -> Slot {
        let root = &self.tree.nodes[0];
        if root.is_leaf() && root.prim_count <= LEAF {
            self.nodes.push(Node::VACANT);
            let slot = self.lay(Subtree::Tree(0), depth + 1);
            self.nodes[0].set(0, &slot);
            Slot { child: self.before.nodes, count: 0, ..slot }
        } else {
            self.lay(Subtree::Tree(0), depth)
        }
    }

    /// Lays out a subtree `depth` levels below the root.
    fn lay<'p>(&mut self, tree: Subtree<'p>, depth: usize) -> Slot
    where
        'a: 'p,
    {
        let mut gathered = Vec::new();
        let mut children = match tree {
            Subtree::Tree(node) if depth >= BALANCE => {
                self.gather(node, &mut gathered);
                vec![Subtree::List(&gathered)]
            }
            tree => vec![tree],
        };
        while children.len() < WIDTH {
            let Some(widest) = self.widest(&children) else { break };
            let [left, right] = self.split(children[widest]);
            children[widest] = left;
            children.insert(widest + 1, right);
        }
        if let [leaf] = children[..] {
            return self.leaf(self.list(leaf));
        }
        let at = self.nodes.len();
        self.nodes.push(Node::VACANT);
        let child = self.before.nodes + to_u32(at);
        let mut whole = Slot { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, child, count: 0 };
        for (i, child) in children.into_iter().enumerate() {
            let slot = self.lay(child, depth + 1);
            self.nodes[at].set(i, &slot);
            whole.low = whole.low.min(slot.low);
            whole.high = whole.high.max(slot.high);
        }
        whole
    }

    /// The subtree to open next: the one with the largest box or the most triangles; none if all are leaves.
    fn widest(&self, trees: &[Subtree<'_>]) -> Option<usize> {
        let size = |tree: &Subtree<'_>| match *tree {
            Subtree::Tree(node) => {
                let node = &self.tree.nodes[node as usize];
                (!node.is_leaf() || node.prim_count > LEAF).then(|| node.aabb().half_area())
            }
            Subtree::List(list) => (list.len() > LEAF as usize).then_some(list.len() as f32),
        };
        let sizes = trees.iter().enumerate().filter_map(|(i, p)| size(p).map(|s| (i, s)));
        sizes.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// The two halves of a subtree that is no leaf.
    fn split<'p>(&self, tree: Subtree<'p>) -> [Subtree<'p>; 2]
    where
        'a: 'p,
    {
        match tree {
            Subtree::Tree(node) if !self.tree.nodes[node as usize].is_leaf() => {
                let first = self.tree.nodes[node as usize].first_index;
                [Subtree::Tree(first), Subtree::Tree(first + 1)]
            }
            tree => {
                let list = self.list(tree);
                let (left, right) = list.split_at(list.len() / 2);
                [Subtree::List(left), Subtree::List(right)]
            }
        }
    }

    /// The triangles of a leaf or a list.
    fn list<'p>(&self, tree: Subtree<'p>) -> &'p [u32]
    where
        'a: 'p,
    {
        match tree {
            Subtree::List(list) => list,
            Subtree::Tree(node) => {
                let tree: &'a Bvh2 = self.tree;
                let node = &tree.nodes[node as usize];
                &tree.primitive_indices[node.first_index as usize..][..node.prim_count as usize]
            }
        }
    }

    /// Appends all triangles below a node of obvhs' tree, which may be any number of levels deep.
    fn gather(&self, node: u32, into: &mut Vec<u32>) {
        let mut stack = vec![node];
        while let Some(at) = stack.pop() {
            let node = &self.tree.nodes[at as usize];
            if node.is_leaf() {
                into.extend_from_slice(self.list(Subtree::Tree(at)));
            } else {
                stack.extend([node.first_index + 1, node.first_index]);
            }
        }
    }

    /// Puts a leaf's triangles in their places and takes their bounds.
    fn leaf(&mut self, list: &[u32]) -> Slot {
        let mut slot = Slot {
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
            child: self.before.triangles + to_u32(self.order.len()),
            count: to_u8(list.len()),
        };
        for &position in list {
            let id = self.ids[position as usize];
            let corners = scaled(self.mesh, id, self.scale);
            slot.low = corners.into_iter().fold(slot.low, Vec3::min);
            slot.high = corners.into_iter().fold(slot.high, Vec3::max);
            self.order.push(id);
        }
        slot
    }
}
