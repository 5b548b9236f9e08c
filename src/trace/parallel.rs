//! Casts parallel rays, such as the sun's: sixteen from any origins in one direction, each until anything is in its way. A
//! node is fetched once for all sixteen, and one ray tests its boxes, widened by the distance between the rays; only
//! triangles are tested in lanes. So casting is fastest where the rays start close together.
//!
//! A lane's triangle test is that of `Bvh::occluded`, operation by operation, and no box that could hold a hit of a
//! lane is skipped; so the answers are the same.

use glam::Vec3;

use super::bvh::{Bvh, STACK, leaf};
use super::packet::{LANES, Lanes, candidates};
use super::ray::Course;
use super::slab::{EMPTY, Node, WIDTH, larger, smaller};
use super::triangle::{Packed, meet};

/// Whether any triangle is in the way of the rays from `origins` along `direction`: `dark[i]` becomes what
/// [`Bvh::occluded`] says, to any distance. Of two slices of different length, the longer one's rest is left alone.
pub(crate) fn occluded(bvh: &Bvh, direction: Vec3, origins: &[Vec3], dark: &mut [bool]) {
    let count = origins.len().min(dark.len());
    let course = Course::new(direction).filter(|_| !bvh.is_empty());
    for (origins, dark) in origins[..count].chunks(LANES).zip(dark[..count].chunks_mut(LANES)) {
        dark.fill(false);
        if let Some(mut beam) = course.and_then(|course| Beam::new(bvh, course, origins)) {
            beam.cast(bvh);
            for (dark, (met, none)) in dark.iter_mut().zip(beam.done.iter().zip(beam.none)) {
                *dark = *met && !none;
            }
        }
    }
}

/// The rays, and whether each has met something.
struct Beam {
    course: Course,
    /// Scaled origins: axis, then lane.
    origins: [Lanes; 3],
    /// The first lane's origin.
    from: [f32; 3],
    /// How far the other origins lie from `from` along each axis, at least and at most.
    apart: [[f32; 2]; 3],
    /// Lanes that have no ray.
    none: [bool; LANES],
    /// Lanes that have no ray or have met something.
    done: [bool; LANES],
}

impl Beam {
    /// `None` if no ray starts anywhere.
    fn new(bvh: &Bvh, course: Course, origins: &[Vec3]) -> Option<Beam> {
        let starts: [Option<[f32; 3]>; LANES] = std::array::from_fn(|i| origins.get(i).and_then(|&o| bvh.scaled(o)));
        let from = starts.into_iter().flatten().next()?;
        // Lanes without a ray repeat the first.
        let origins: [Lanes; 3] = std::array::from_fn(|axis| starts.map(|start| start.unwrap_or(from)[axis]));
        let apart = std::array::from_fn(|axis| {
            let far = origins[axis].map(|o| o - from[axis]);
            [far.into_iter().fold(0.0, smaller), far.into_iter().fold(0.0, larger)]
        });
        let none = starts.map(|start| start.is_none());
        Some(Beam { course, origins, from, apart, none, done: none })
    }

    fn cast(&mut self, bvh: &Bvh) {
        let (nodes, triangles): (&[Node], &[Packed]) = (&bvh.nodes, &bvh.triangles);
        let mut stack = [bvh.root; STACK];
        let mut held = 1;
        while held > 0 {
            held -= 1;
            let node = &nodes[stack[held] as usize];
            let enters = self.enters(node);
            for (i, enters) in enters.into_iter().enumerate() {
                if !enters || node.count[i] == EMPTY {
                    continue;
                }
                if node.count[i] == 0 {
                    stack[held] = node.child[i];
                    held += 1;
                    continue;
                }
                for packed in leaf(triangles, node, i) {
                    self.intersect(packed);
                }
                if self.done.iter().all(|&done| done) {
                    return;
                }
            }
        }
    }

    /// Which boxes any lane may enter.
    #[inline(always)]
    fn enters(&self, node: &Node) -> [bool; WIDTH] {
        let [near, far] = node.planes_of_many(&self.from, &self.apart, self.course.signs);
        let (mut entry, mut exit) = ([0f32; WIDTH], [f32::INFINITY; WIDTH]);
        for axis in 0..3 {
            for i in 0..WIDTH {
                entry[i] = larger(near[axis][i] * self.course.inverse[axis], entry[i]);
                exit[i] = smaller(far[axis][i] * self.course.inverse[axis], exit[i]);
            }
        }
        std::array::from_fn(|i| entry[i] <= exit[i])
    }

    /// Tests a triangle in every lane.
    #[inline(always)]
    fn intersect(&mut self, packed: &Packed) {
        let [x, y, z] = self.course.axes;
        let [shear_x, shear_y] = self.course.shear;
        let depths = packed.corners.map(|p| self.origins[z].map(|o| p[z] - o));
        let across = |corner: usize, axis: usize, shear: f32| -> Lanes {
            let at = packed.corners[corner][axis];
            std::array::from_fn(|l| at - self.origins[axis][l] - shear * depths[corner][l])
        };
        let sheared = [0, 1, 2].map(|corner| [across(corner, x, shear_x), across(corner, y, shear_y)]);
        let candidates = candidates(&sheared);
        for l in (0..LANES).filter(|&l| candidates[l]) {
            if !self.done[l] {
                let corner = |i: usize| [sheared[i][0][l], sheared[i][1][l], depths[i][l]];
                self.done[l] = meet([corner(0), corner(1), corner(2)], self.course.depth).is_some();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Mesh;
    use crate::trace::Ray;
    use glam::DVec3;
    use rand::{RngExt, SeedableRng};
    use rand_pcg::Pcg64Mcg;

    /// Triangles of a size in a cube of the edge 2, `far` from the coordinates' zero.
    fn soup(rng: &mut Pcg64Mcg, n: u32, size: f32, far: f32) -> Mesh {
        let mut corners = Vec::new();
        for _ in 0..n {
            let at = vector(rng) + far;
            (0..3).for_each(|_| corners.push(at + size * vector(rng)));
        }
        let triangles: Vec<[u32; 3]> = (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect();
        Mesh { origin: DVec3::ZERO, positions: corners.into(), triangles: triangles.into() }
    }

    fn vector(rng: &mut Pcg64Mcg) -> Vec3 {
        Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0f32..1.0)))
    }

    #[test]
    fn each_ray_is_as_dark_as_alone() {
        let mut rng = Pcg64Mcg::seed_from_u64(3);
        let mut counts = [0; 2];
        for (n, size, far) in [(0, 1.0, 0.0), (1, 2.0, 0.0), (300, 0.3, 0.0), (5000, 0.05, 0.0), (5000, 0.05, 1000.0)] {
            let mesh = soup(&mut rng, n, size, far);
            let bvh = Bvh::build(&mesh);
            for round in 0..200 {
                let direction = match round % 8 {
                    0 => Vec3::Z,
                    1 => Vec3::new(0.0, -1.0, -0.0),
                    2 => Vec3::new(1.0, 0.5, 0.0),
                    _ => vector(&mut rng),
                };
                // From one point to all over the place; some on corners of triangles, where rounding counts.
                let apart = [0.0, 1e-4, 0.05, 1.0][round % 4];
                let middle = vector(&mut rng) + far;
                let mut origins: Vec<Vec3> =
                    (0..rng.random_range(1..40)).map(|_| middle + apart * vector(&mut rng)).collect();
                if !mesh.positions.is_empty() {
                    let corner = mesh.positions[rng.random_range(0..mesh.positions.len())];
                    origins.extend([corner - direction, corner - direction * 1e-3, corner + direction]);
                }
                let mut dark = vec![true; origins.len()];
                occluded(&bvh, direction, &origins, &mut dark);
                for (&origin, dark) in origins.iter().zip(dark) {
                    let alone = bvh.occluded(&Ray { origin, direction }, f32::INFINITY);
                    assert_eq!(dark, alone, "{n} triangles, from {origin} along {direction}");
                    counts[usize::from(dark)] += 1;
                }
            }
        }
        assert!(counts.iter().all(|&count| count > 5000), "{counts:?}");
    }

    #[test]
    fn what_is_no_ray_meets_nothing() {
        let mut rng = Pcg64Mcg::seed_from_u64(4);
        let bvh = Bvh::build(&soup(&mut rng, 2000, 0.5, 0.0));
        let (below, beyond) = (Vec3::Z * -5.0, Vec3::NAN);
        let mut dark = [true; 4];
        occluded(&bvh, Vec3::Z, &[beyond, below, Vec3::splat(f32::INFINITY), below], &mut dark);
        assert_eq!(dark, [false, true, false, true]);
        for direction in [Vec3::ZERO, Vec3::NAN] {
            let mut dark = [true; 4];
            occluded(&bvh, direction, &[below; 3], &mut dark);
            assert_eq!(dark, [false, false, false, true], "the rest is left alone");
        }
    }
}
