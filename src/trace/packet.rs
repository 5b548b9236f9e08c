//! Sixteen rays from one point, cast together: a node or a triangle is fetched once for all of them, moved to their origin
//! once, and tested in lanes that the compiler turns into vectors.
//!
//! All lanes share the order of their axes and the signs of their directions (`tile` sees to it), so that nothing in
//! the lanes branches. A lane's arithmetic is that of `Bvh::nearest`, operation by operation.

use super::bvh::{Best, Bvh, STACK, leaf};
use super::ray::Course;
use super::slab::{EMPTY, Node, WIDTH, larger, smaller};
use super::triangle::{Packed, meet};

/// Rays of a packet.
pub(super) const LANES: usize = 16;

/// A value for each ray.
pub(super) type Lanes = [f32; LANES];

/// The rays, and the nearest meeting of each.
#[derive(Debug, Clone)]
pub(super) struct Packet {
    axes: [usize; 3],
    signs: u8,
    inverse: [Lanes; 3],
    shear: [Lanes; 2],
    depth: Lanes,
    /// How far each lane still looks: the distance of `best`; below 0 for a lane without a ray.
    reach: Lanes,
    best: [Best; LANES],
}

impl Packet {
    /// A packet of at most [`LANES`] courses that agree in axes and signs; `None` without courses.
    pub(super) fn new(courses: &[Course]) -> Option<Packet> {
        let first = courses.first()?;
        // Lanes without a ray repeat the first and reach nowhere.
        let lane = |i: usize| courses.get(i).unwrap_or(first);
        let lanes = |f: &dyn Fn(&Course) -> f32| std::array::from_fn(|i| f(lane(i)));
        Some(Packet {
            axes: first.axes,
            signs: first.signs,
            inverse: std::array::from_fn(|axis| lanes(&|c| c.inverse[axis])),
            shear: std::array::from_fn(|axis| lanes(&|c| c.shear[axis])),
            depth: lanes(&|c| c.depth),
            reach: std::array::from_fn(|i| if i < courses.len() { f32::INFINITY } else { -1.0 }),
            best: [Best::NONE; LANES],
        })
    }

    /// The nearest triangle of each lane.
    pub(super) fn cast(mut self, bvh: &Bvh, origin: &[f32; 3]) -> [Best; LANES] {
        let (nodes, triangles): (&[Node], &[Packed]) = (&bvh.nodes, &bvh.triangles);
        let mut stack = [(0f32, bvh.root); STACK];
        let mut held = usize::from(!bvh.is_empty());
        while held > 0 {
            held -= 1;
            let (entry, node) = stack[held];
            if entry > self.farthest() {
                continue;
            }
            let node = &nodes[node as usize];
            let [near, far] = node.planes(origin, self.signs);
            let from = held;
            for i in 0..WIDTH {
                if node.count[i] == EMPTY {
                    break;
                }
                let entry = self.enter(near.map(|axis| axis[i]), far.map(|axis| axis[i]));
                if entry.is_infinite() {
                    continue;
                }
                if node.count[i] == 0 {
                    stack[held] = (entry, node.child[i]);
                    held += 1;
                } else {
                    for packed in leaf(triangles, node, i) {
                        self.intersect(packed, origin);
                    }
                }
            }
            // Nearest on top.
            stack[from..held].sort_unstable_by(|a, b| b.0.total_cmp(&a.0));
        }
        self.best
    }

    /// The farthest that any lane still looks.
    #[inline(always)]
    fn farthest(&self) -> f32 {
        fold(self.reach, larger)
    }

    /// The least distance at which a lane enters a box; infinite if no lane enters within its reach.
    #[inline(always)]
    fn enter(&self, near: [f32; 3], far: [f32; 3]) -> f32 {
        let mut entry = [0f32; LANES];
        let mut exit = self.reach;
        for axis in 0..3 {
            for l in 0..LANES {
                entry[l] = larger(near[axis] * self.inverse[axis][l], entry[l]);
                exit[l] = smaller(far[axis] * self.inverse[axis][l], exit[l]);
            }
        }
        for l in 0..LANES {
            entry[l] = if entry[l] <= exit[l] { entry[l] } else { f32::INFINITY };
        }
        fold(entry, smaller)
    }

    /// Offers a triangle to every lane.
    #[inline(always)]
    fn intersect(&mut self, packed: &Packed, origin: &[f32; 3]) {
        let [x, y, z] = self.axes;
        let moved = packed.corners.map(|p| [p[x] - origin[x], p[y] - origin[y], p[z] - origin[z]]);
        let mut sheared = [[[0f32; LANES]; 2]; 3];
        for (sheared, moved) in sheared.iter_mut().zip(&moved) {
            for axis in 0..2 {
                for (at, shear) in sheared[axis].iter_mut().zip(&self.shear[axis]) {
                    *at = moved[axis] - shear * moved[2];
                }
            }
        }
        let candidates = candidates(&sheared);
        for l in 0..LANES {
            if candidates[l] {
                let corner = |i: usize| [sheared[i][0][l], sheared[i][1][l], moved[i][2]];
                if let Some(meeting) = meet([corner(0), corner(1), corner(2)], self.depth[l]) {
                    self.best[l].offer(packed.id, meeting);
                    self.reach[l] = smaller(self.best[l].t, self.reach[l]);
                }
            }
        }
    }
}

/// The lanes whose rays may meet a triangle, by its edge functions; `sheared` is x and y of each corner.
#[inline(always)]
pub(super) fn candidates([a, b, c]: &[[Lanes; 2]; 3]) -> [bool; LANES] {
    let mut candidates = [false; LANES];
    for l in 0..LANES {
        let u = c[0][l] * b[1][l] - c[1][l] * b[0][l];
        let v = a[0][l] * c[1][l] - a[1][l] * c[0][l];
        let w = b[0][l] * a[1][l] - b[1][l] * a[0][l];
        let low = smaller(smaller(u, v), w);
        let high = larger(larger(u, v), w);
        // What is no number has no sign.
        candidates[l] = !((low < 0.0) & (high > 0.0));
    }
    candidates
}

/// Folds lanes in halves, which vectors can.
#[inline(always)]
fn fold(mut lanes: Lanes, f: impl Fn(f32, f32) -> f32) -> f32 {
    let mut n = LANES / 2;
    while n > 0 {
        for l in 0..n {
            lanes[l] = f(lanes[l], lanes[l + n]);
        }
        n /= 2;
    }
    lanes[0]
}
