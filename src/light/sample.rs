//! Which triangles are looked at.

use glam::Vec3;

use super::directions::dome;
use super::draw::unit;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;

/// Triangles that a sample has, unless another number is asked for. Twice as many tell cities no better, and make pairs of a
/// rough mesh so near that its noise decides.
pub const TRIANGLES: usize = 6_000;

/// The fewest pixels that a triangle is seen in, below which it is passed over: of fewer, most lie on its edges.
const PIXELS: f32 = 12.0;

/// Cells of the sphere that normals are counted in.
const CELLS: usize = 48;

/// About `count` triangles, ascending: spread over the mesh by area, and over normals, so that ground does not drown walls
/// and roofs. A triangle's weight is its area over the square root of the area in its normal's cell. Each cell is sampled
/// along the order of the file at one place in each `1 / count` of all weight, the place within drawn by a hash.
///
/// `seen` is the number of pixels in which a frame sees each triangle, 0 where none does; triangles of fewer than 12 are
/// passed over. If it is empty, all are taken.
pub fn sample(mesh: &Mesh, up: Vec3, seen: &[f32], count: usize) -> Vec<TriangleId> {
    let cells = dome(up, CELLS, -90.0);
    let visible = |t: &TriangleId| seen.is_empty() || seen.get(t.index()).is_some_and(|pixels| *pixels >= PIXELS);
    let sized = |t: TriangleId| {
        let [a, b, c] = mesh.corners(t);
        let across = (b - a).as_dvec3().cross((c - a).as_dvec3());
        let (area, normal) = (across.length(), across.try_normalize()?.as_vec3());
        let nearer =
            |best: usize, cell: usize| if cells[cell].dot(normal) > cells[best].dot(normal) { cell } else { best };
        Some((t, area, (1..CELLS).fold(0, nearer)))
    };
    let candidates = || TriangleId::all(mesh.len()).filter(visible).filter_map(sized);
    let mut areas = [0f64; CELLS];
    candidates().for_each(|(_, area, cell)| areas[cell] += area);
    let weight = |area: f64, cell: usize| area / areas[cell].sqrt();
    let all: f64 = areas.iter().map(|area| area.sqrt()).sum();
    let mut step = all / count.max(1) as f64;
    // A triangle is taken once however large it is: the others then share what it leaves.
    for _ in 0..3 {
        let (mut large, mut rest) = (0usize, 0.0);
        candidates().for_each(|(_, area, cell)| match weight(area, cell) {
            w if w >= step => large += 1,
            w => rest += w,
        });
        step = rest / count.saturating_sub(large).max(1) as f64;
        if step <= 0.0 {
            break;
        }
    }
    let mut along: [f64; CELLS] = std::array::from_fn(|cell| unit(cell as u64, 0));
    let mut next: [u64; CELLS] = [1; CELLS];
    let mut taken = Vec::with_capacity(count);
    for (t, area, cell) in candidates() {
        let share = if step > 0.0 { weight(area, cell) / step } else { 1.0 };
        // `along` is what is left until the next place.
        along[cell] -= share;
        if share >= 1.0 || along[cell] <= 0.0 {
            taken.push(t);
            while along[cell] <= 0.0 {
                // From this place to the end of its interval, and on to the place within the next.
                along[cell] += 1.0 - unit(cell as u64, next[cell] - 1) + unit(cell as u64, next[cell]);
                next[cell] += 1;
            }
        }
    }
    taken
}
