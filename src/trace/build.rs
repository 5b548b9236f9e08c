//! Building: obvhs groups boxes into a binary tree; only its shape is taken over.
//!
//! Bounds are taken afresh from the triangles, so that no digit of them passes through obvhs. Its clustering is given
//! boxes that are a little too large, each by another fraction: where many are alike, as in a flat regular grid or a mesh
//! that repeats its faces, it would else merge one pair a pass. Subtrees deeper than traversal can hold are laid out anew,
//! balanced. While building, obvhs holds about 200 bytes a triangle.

use glam::{Vec3, Vec3A};
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::Bvh;
use super::bvh::DEPTH;
use super::ray::scale_below_one;
use super::slab::{Node, WIDTH};
use super::triangle::Packed;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;

/// Triangles of a leaf, at most.
const LEAF: usize = 4;

/// From this depth on a subtree is laid out balanced: that takes at most 16 levels of four for 2^32 triangles.
const BALANCE: usize = DEPTH - 16;

impl Bvh {
    /// Builds the tree over a mesh's triangles, those without area left out. One thread; the result is a function of
    /// the mesh alone.
    pub fn build(mesh: &Mesh) -> Bvh {
        let ids: Vec<TriangleId> = (0..mesh.len() as TriangleId).filter(|&t| mesh.normal(t).is_some()).collect();
        let size = ids.iter().flat_map(|&t| mesh.corners(t)).fold(0f32, |m, p| m.max(p.abs().max_element()));
        if ids.is_empty() {
            return Bvh { nodes: Vec::new(), triangles: Vec::new(), scale: 1.0 };
        }
        let scale = scale_below_one(size);
        let tree = cluster(mesh, &ids, scale);
        let mut layout = Layout { mesh, ids: &ids, tree: &tree, nodes: Vec::new(), triangles: Vec::new(), scale };
        layout.triangles.reserve_exact(ids.len());
        layout.root();
        layout.nodes.shrink_to_fit();
        Bvh { nodes: layout.nodes, triangles: layout.triangles, scale }
    }
}

/// A triangle's corners in scaled coordinates.
fn scaled(mesh: &Mesh, id: TriangleId, scale: f64) -> [Vec3; 3] {
    mesh.corners(id).map(|p| (p.as_dvec3() * scale).as_vec3())
}

/// obvhs' tree over positions in `ids`.
fn cluster(mesh: &Mesh, ids: &[TriangleId], scale: f64) -> Bvh2 {
    let tight = |position: u32| {
        let corners = scaled(mesh, ids[position as usize], scale).map(Vec3A::from);
        Aabb::from_points(&corners)
    };
    let all = 0..ids.len() as u32;
    let loose: Vec<Aabb> = all
        .clone()
        .map(|position| {
            let tight = tight(position);
            // Weyl's sequence of the golden ratio, up to a 128th of the box, on both sides: sorting goes by the centre.
            let share = position.wrapping_mul(0x9E37_79B9) as f32 / (1u64 << 39) as f32;
            let margin = (tight.max - tight.min) * share;
            Aabb::new(tight.min - margin, tight.max + margin)
        })
        .collect();
    let mut tree = PlocBuilder::new().build(PlocSearchDistance::Low, &loose, all.collect(), SortPrecision::U64, 2);
    drop(loose);
    for node in tree.nodes.iter_mut().filter(|n| n.is_leaf()) {
        node.set_aabb(tight(node.first_index));
    }
    tree.refit_all();
    ReinsertionOptimizer::default().run(&mut tree, 0.02, None);
    collapse(&mut tree, LEAF as u32, 3.0);
    tree
}

/// A subtree still to be laid out.
#[derive(Clone, Copy)]
enum Part<'a> {
    /// A node of obvhs' tree.
    Tree(u32),
    /// Triangles (positions in `ids`), halved by their order.
    List(&'a [u32]),
}

/// A subtree laid out: what its parent's slot says.
struct Slot {
    low: Vec3,
    high: Vec3,
    child: u32,
    count: u8,
}

struct Layout<'a> {
    mesh: &'a Mesh,
    ids: &'a [TriangleId],
    tree: &'a Bvh2,
    nodes: Vec<Node>,
    triangles: Vec<Packed>,
    scale: f64,
}

impl<'a> Layout<'a> {
    /// Lays out everything. The root is a node even over one leaf.
    fn root(&mut self) {
        let root = &self.tree.nodes[0];
        if root.is_leaf() && root.prim_count as usize <= LEAF {
            self.nodes.push(Node::VACANT);
            let slot = self.lay(Part::Tree(0), 1);
            self.fill(0, 0, &slot);
        } else {
            self.lay(Part::Tree(0), 0);
        }
    }

    /// Lays out a subtree `depth` levels below the root.
    fn lay<'p>(&mut self, part: Part<'p>, depth: usize) -> Slot
    where
        'a: 'p,
    {
        let mut gathered = Vec::new();
        let mut children = match part {
            Part::Tree(node) if depth >= BALANCE => {
                self.gather(node, &mut gathered);
                vec![Part::List(&gathered)]
            }
            part => vec![part],
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
        let mut whole = Slot { low: Vec3::INFINITY, high: Vec3::NEG_INFINITY, child: at as u32, count: 0 };
        for (i, child) in children.into_iter().enumerate() {
            let slot = self.lay(child, depth + 1);
            self.fill(at, i, &slot);
            whole.low = whole.low.min(slot.low);
            whole.high = whole.high.max(slot.high);
        }
        whole
    }

    /// Which of the parts to open next: the one with the largest box or the most triangles; none if all are leaves.
    fn widest(&self, parts: &[Part<'_>]) -> Option<usize> {
        let size = |part: &Part<'_>| match *part {
            Part::Tree(node) => {
                let node = &self.tree.nodes[node as usize];
                (!node.is_leaf() || node.prim_count as usize > LEAF).then(|| node.aabb().half_area())
            }
            Part::List(list) => (list.len() > LEAF).then_some(list.len() as f32),
        };
        let sizes = parts.iter().enumerate().filter_map(|(i, p)| size(p).map(|s| (i, s)));
        sizes.max_by(|a, b| a.1.total_cmp(&b.1)).map(|(i, _)| i)
    }

    /// The two halves of a part that is no leaf.
    fn split<'p>(&self, part: Part<'p>) -> [Part<'p>; 2]
    where
        'a: 'p,
    {
        match part {
            Part::Tree(node) if !self.tree.nodes[node as usize].is_leaf() => {
                let first = self.tree.nodes[node as usize].first_index;
                [Part::Tree(first), Part::Tree(first + 1)]
            }
            part => {
                let list = self.list(part);
                let (left, right) = list.split_at(list.len() / 2);
                [Part::List(left), Part::List(right)]
            }
        }
    }

    /// The triangles of a leaf or a list.
    fn list<'p>(&self, part: Part<'p>) -> &'p [u32]
    where
        'a: 'p,
    {
        match part {
            Part::List(list) => list,
            Part::Tree(node) => {
                let tree: &'a Bvh2 = self.tree;
                let node = &tree.nodes[node as usize];
                &tree.primitive_indices[node.first_index as usize..][..node.prim_count as usize]
            }
        }
    }

    /// All triangles below a node of obvhs' tree, which may be any number of levels deep.
    fn gather(&self, node: u32, into: &mut Vec<u32>) {
        let mut stack = vec![node];
        while let Some(at) = stack.pop() {
            let node = &self.tree.nodes[at as usize];
            if node.is_leaf() {
                into.extend_from_slice(self.list(Part::Tree(at)));
            } else {
                stack.extend([node.first_index + 1, node.first_index]);
            }
        }
    }

    /// Copies a leaf's triangles and takes their bounds.
    fn leaf(&mut self, list: &[u32]) -> Slot {
        let mut slot = Slot {
            low: Vec3::INFINITY,
            high: Vec3::NEG_INFINITY,
            child: self.triangles.len() as u32,
            count: list.len() as u8,
        };
        for &position in list {
            let id = self.ids[position as usize];
            let corners = scaled(self.mesh, id, self.scale);
            slot.low = corners.into_iter().fold(slot.low, Vec3::min);
            slot.high = corners.into_iter().fold(slot.high, Vec3::max);
            self.triangles.push(Packed { corners: corners.map(|p| p.to_array()), id });
        }
        slot
    }

    /// Writes a child into its parent.
    fn fill(&mut self, node: usize, i: usize, slot: &Slot) {
        let node = &mut self.nodes[node];
        for axis in 0..3 {
            node.low[axis][i] = slot.low[axis];
            node.high[axis][i] = slot.high[axis];
        }
        node.child[i] = slot.child;
        node.count[i] = slot.count;
    }
}
