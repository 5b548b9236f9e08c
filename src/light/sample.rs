//! Which triangles are looked at.

use glam::Vec3;

use crate::base::ids::TriangleId;
use crate::scene::Mesh;

/// Triangles to look at, ascending.
pub(crate) fn sample(mesh: &Mesh, _: Vec3, seen: &[f32], count: usize) -> Vec<TriangleId> {
    let good: Vec<TriangleId> = TriangleId::all(mesh.len()).filter(|t| seen[t.index()] >= 12.0).collect();
    let step = good.len().div_ceil(count.max(1)).max(1);
    good.into_iter().step_by(step).collect()
}
