//! obvhs' binary tree over the triangles of a chunk; only the tree's shape is used.
//!
//! Bounds are taken afresh from the triangles, so that no digit of them passes through obvhs. obvhs clusters boxes that are
//! a little too large, each by another fraction: where many boxes are alike, as in a flat regular grid or a mesh that
//! repeats its faces, it would otherwise merge one pair a pass. While building, obvhs holds about 200 bytes a triangle.

use glam::Vec3A;
use obvhs::aabb::Aabb;
use obvhs::bvh2::Bvh2;
use obvhs::bvh2::leaf_collapser::collapse;
use obvhs::bvh2::reinsertion::ReinsertionOptimizer;
use obvhs::ploc::{PlocBuilder, PlocSearchDistance, SortPrecision};

use super::slot::scaled;
use crate::base::convert::to_u32;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;

/// Triangles of a leaf, at most.
pub(super) const LEAF: u32 = 4;

/// The tree over positions in `ids`.
pub(super) fn cluster(mesh: &Mesh, ids: &[TriangleId], scale: f64) -> Bvh2 {
    let tight = |position: u32| {
        let corners = scaled(mesh, ids[position as usize], scale).map(Vec3A::from);
        Aabb::from_points(&corners)
    };
    let all = 0..to_u32(ids.len());
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
    collapse(&mut tree, LEAF, 3.0);
    tree
}
