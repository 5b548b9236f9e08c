//! A block's triangles, each with its material, and the shapes that make them: grids over four corners, grids over a
//! triangle, boxes, lathes and crowns.

use glam::{DVec2, DVec3, Vec3};
use rand::RngExt;
use rand_pcg::Pcg64;

use super::finish::{Finish, Substance};
use super::real::palette::worn;
use super::town::Ground;
use super::world::World;
use crate::base::convert::{Cut, to_u32};
use crate::scene::Material;

/// Triangles with a material each; vertices in mesh coordinates.
#[derive(Debug, Clone, Default)]
pub(super) struct Surface {
    /// Vertices.
    pub vertices: Vec<DVec3>,
    /// Vertex indices, counter-clockwise from outside.
    pub triangles: Vec<[u32; 3]>,
    /// The material of each triangle.
    pub materials: Vec<Material>,
    /// The substance of each triangle.
    pub substances: Vec<Substance>,
    /// Where each triangle is: in the town, in the mesh that is handed out, or in both.
    pub parts: Vec<Part>,
}

/// Where a triangle is.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub(super) enum Part {
    /// In the town that is photographed and in the mesh that is handed out.
    #[default]
    Both,
    /// In the town alone: a reconstruction missed it.
    Town,
    /// In the mesh alone: a reconstruction made it up.
    Mesh,
}

/// An axis-parallel rectangle on the ground of a block, metres from the block's corner.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Rect {
    /// Least corner.
    pub low: DVec2,
    /// Greatest corner.
    pub high: DVec2,
}

impl Rect {
    /// The rectangle of `x0..x1` and `y0..y1`.
    pub(super) fn new(x0: f64, x1: f64, y0: f64, y1: f64) -> Rect {
        Rect { low: DVec2::new(x0, y0), high: DVec2::new(x1, y1) }
    }

    /// The middle.
    pub(super) fn centre(&self) -> DVec2 {
        (self.low + self.high) * 0.5
    }

    /// Extents along x and y.
    pub(super) fn size(&self) -> DVec2 {
        self.high - self.low
    }
}

/// Where an object stands. The object's x axis is turned from the block's; its z counts from the ground under its middle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Spot {
    /// The object's origin in its block, metres.
    pub at: DVec2,
    /// Cosine and sine of the turn from the block's x axis.
    pub turn: DVec2,
}

impl Spot {
    /// A spot at a point of the block, turned by an angle in radians.
    pub(super) fn new(at: DVec2, angle: f64) -> Spot {
        Spot { at, turn: DVec2::from_angle(angle) }
    }

    /// A point in the block's axes that is given in the object's own.
    pub(super) fn to_block(self, own: DVec2) -> DVec2 {
        self.at + self.turn.rotate(own)
    }
}

/// One block under construction.
pub(super) struct Block {
    /// The triangles made so far.
    pub surface: Surface,
    /// The block's own random numbers.
    pub rng: Pcg64,
    /// The ground that the block lies on.
    pub ground: Ground,
    /// Edge length that grids aim at, metres.
    pub cell: f64,
    /// The world that the block lies in.
    pub world: World,
    /// Where the triangles are that are made next.
    pub part: Part,
}

impl Block {
    /// The number of cells that a length is cut into.
    pub(super) fn cells(&self, length: f64) -> usize {
        usize::cut((length / self.cell).round()).max(1)
    }

    /// The height, in an object's own axes, at which the object meets the ground: a little below, so that no gap shows.
    pub(super) fn footing(&self, spot: Spot, own: DVec2) -> f64 {
        self.ground.point(spot.to_block(own)).z - self.ground.point(spot.at).z - 0.03
    }

    /// A piece of ground.
    pub(super) fn floor(&mut self, rect: Rect, finish: &Finish) {
        self.floor_cells(rect, self.cell, |_, _| *finish);
    }

    /// A piece of ground in cells of a stated length; `finish` gives a cell's finish by column and row.
    pub(super) fn floor_cells(&mut self, rect: Rect, cell: f64, finish: impl Fn(usize, usize) -> Finish) {
        let size = rect.size();
        if size.min_element() < 1e-6 {
            return;
        }
        let [nu, nv] = [size.x, size.y].map(|l| usize::cut((l / cell).round()).max(1));
        let ground = self.ground;
        let at = |u: f64, v: f64| ground.point(rect.low + size * DVec2::new(u, v));
        self.grid(nu, nv, at, finish);
    }

    /// A patch over four corners, counter-clockwise from outside, in an object's axes.
    pub(super) fn patch(&mut self, spot: Spot, corners: [DVec3; 4], finish: &Finish) {
        self.patch_cells(spot, corners, |_, _| *finish);
    }

    /// A patch over four corners; `finish` gives a cell's finish by its share along the first and the second edge.
    pub(super) fn patch_cells(&mut self, spot: Spot, corners: [DVec3; 4], finish: impl Fn(f64, f64) -> Finish) {
        let [a, b, c, d] = corners;
        let nu = self.cells(a.distance(b).max(d.distance(c)));
        let nv = self.cells(a.distance(d).max(b.distance(c)));
        let (ground, base) = (self.ground, self.ground.point(spot.at).z);
        let at = |u: f64, v: f64| raise(&ground, spot, base, a.lerp(b, u).lerp(d.lerp(c, u), v));
        let share = |i: usize, n: usize| (i as f64 + 0.5) / n as f64;
        self.grid(nu, nv, at, |i, j| finish(share(i, nu), share(j, nv)));
    }

    /// A flat triangle, counter-clockwise from outside, cut into equal smaller ones.
    pub(super) fn gable(&mut self, spot: Spot, corners: [DVec3; 3], finish: &Finish) {
        let [a, b, c] = corners;
        let n = self.cells(a.distance(b).max(b.distance(c)).max(c.distance(a)));
        let base = self.ground.point(spot.at).z;
        let first = to_u32(self.surface.vertices.len());
        for row in 0..=n {
            for column in 0..=n - row {
                let own = a + (b - a) * (column as f64 / n as f64) + (c - a) * (row as f64 / n as f64);
                self.surface.vertices.push(raise(&self.ground, spot, base, own));
            }
        }
        let index =
            |row: usize, column: usize| first + to_u32(row * (n + 1) - row * row.saturating_sub(1) / 2 + column);
        for row in 0..n {
            for column in 0..n - row {
                let (p, q, r) = (index(row, column), index(row, column + 1), index(row + 1, column));
                self.triangle([p, q, r], finish);
                if column + 1 < n - row {
                    self.triangle([q, index(row + 1, column + 1), r], finish);
                }
            }
        }
    }

    /// A box without its underside.
    pub(super) fn solid(&mut self, spot: Spot, low: DVec3, high: DVec3, sides: &Finish, top: &Finish) {
        let corner = |x: bool, y: bool, z: bool| {
            let pick = |up: bool, a: f64, b: f64| if up { b } else { a };
            DVec3::new(pick(x, low.x, high.x), pick(y, low.y, high.y), pick(z, low.z, high.z))
        };
        let ring = [(false, false), (true, false), (true, true), (false, true)];
        for k in 0..4 {
            let ((ax, ay), (bx, by)) = (ring[k], ring[(k + 1) % 4]);
            let side = [corner(ax, ay, false), corner(bx, by, false), corner(bx, by, true), corner(ax, ay, true)];
            self.patch(spot, side, sides);
        }
        self.patch(spot, ring.map(|(x, y)| corner(x, y, true)), top);
    }

    /// A closed shape turned about the object's z axis: `profile` is radius and height from the bottom up; a radius of
    /// 0 closes it. Radii stray by `jitter`, relative.
    pub(super) fn lathe(&mut self, spot: Spot, profile: &[DVec2], sides: usize, jitter: f64, finish: &Finish) {
        let base = self.ground.point(spot.at).z;
        let first = to_u32(self.surface.vertices.len());
        for (level, ring) in profile.iter().enumerate() {
            for side in 0..sides {
                let stray = 1.0 + jitter * self.rng.random_range(-1.0..=1.0);
                // Every other ring is turned by half a side, which makes even triangles.
                let angle = std::f64::consts::TAU * (side as f64 + 0.5 * (level % 2) as f64) / sides as f64;
                let own = (DVec2::from_angle(angle) * ring.x * stray).extend(ring.y);
                self.surface.vertices.push(raise(&self.ground, spot, base, own));
            }
        }
        let index = |level: usize, side: usize| first + to_u32(level * sides + side % sides);
        for level in 1..profile.len() {
            let (narrow_below, narrow_above) = (profile[level - 1].x == 0.0, profile[level].x == 0.0);
            for side in 0..sides {
                // The ring below is one half-turn behind on even levels.
                let (b, t) = if level % 2 == 1 { (side + 1, side) } else { (side, side + 1) };
                let (p, q) = (index(level - 1, side), index(level - 1, side + 1));
                let (s, u) = (index(level, side), index(level, side + 1));
                if !narrow_below {
                    self.triangle([p, q, index(level, t)], finish);
                }
                if !narrow_above {
                    self.triangle([index(level - 1, b), u, s], finish);
                }
            }
        }
    }

    /// A crown: a sphere of 80 triangles whose vertices stray in and out.
    pub(super) fn blob(&mut self, spot: Spot, centre: DVec3, radii: DVec3, jitter: f64, finish: &Finish) {
        let base = self.ground.point(spot.at).z;
        let first = to_u32(self.surface.vertices.len());
        let (vertices, triangles) = sphere();
        for v in vertices {
            let stray = 1.0 + jitter * self.rng.random_range(-1.0..=1.0);
            let own = centre + v.as_dvec3() * radii * stray;
            self.surface.vertices.push(raise(&self.ground, spot, base, own));
        }
        for t in triangles {
            self.triangle(t.map(|i| i + first), finish);
        }
    }

    /// One triangle over existing vertices.
    fn triangle(&mut self, indices: [u32; 3], finish: &Finish) {
        let finish = if self.world == World::Real { worn(finish) } else { *finish };
        self.surface.triangles.push(indices);
        self.surface.materials.push(finish.sample(&mut self.rng));
        self.surface.substances.push(finish.substance);
        self.surface.parts.push(self.part);
    }

    /// A grid of `nu` by `nv` cells of two triangles over the unit square; `at` gives a vertex, `finish` a cell's finish.
    fn grid(&mut self, nu: usize, nv: usize, at: impl Fn(f64, f64) -> DVec3, finish: impl Fn(usize, usize) -> Finish) {
        let first = to_u32(self.surface.vertices.len());
        for j in 0..=nv {
            for i in 0..=nu {
                self.surface.vertices.push(at(i as f64 / nu as f64, j as f64 / nv as f64));
            }
        }
        let index = |i: usize, j: usize| first + to_u32(j * (nu + 1) + i);
        for j in 0..nv {
            for i in 0..nu {
                let [a, b, c, d] = [index(i, j), index(i + 1, j), index(i + 1, j + 1), index(i, j + 1)];
                let finish = finish(i, j);
                // Diagonals alternate, so that no direction shows.
                let halves = if (i + j) % 2 == 0 { [[a, b, c], [a, c, d]] } else { [[a, b, d], [b, c, d]] };
                for half in halves {
                    self.triangle(half, &finish);
                }
            }
        }
    }
}

/// A point in an object's axes, in mesh coordinates.
fn raise(ground: &Ground, spot: Spot, base: f64, own: DVec3) -> DVec3 {
    let at = ground.point(spot.to_block(own.truncate()));
    DVec3::new(at.x, at.y, base + own.z)
}

/// An icosahedron with every face cut in four: 42 unit vectors and 80 triangles.
fn sphere() -> ([Vec3; 42], [[u32; 3]; 80]) {
    const G: f32 = 1.618_034;
    const CORNERS: [[f32; 3]; 12] = [
        [-1.0, G, 0.0],
        [1.0, G, 0.0],
        [-1.0, -G, 0.0],
        [1.0, -G, 0.0],
        [0.0, -1.0, G],
        [0.0, 1.0, G],
        [0.0, -1.0, -G],
        [0.0, 1.0, -G],
        [G, 0.0, -1.0],
        [G, 0.0, 1.0],
        [-G, 0.0, -1.0],
        [-G, 0.0, 1.0],
    ];
    #[rustfmt::skip]
    const FACES: [[u32; 3]; 20] = [
        [0, 11, 5], [0, 5, 1], [0, 1, 7], [0, 7, 10], [0, 10, 11], [1, 5, 9], [5, 11, 4], [11, 10, 2], [10, 7, 6], [7, 1, 8],
        [3, 9, 4], [3, 4, 2], [3, 2, 6], [3, 6, 8], [3, 8, 9], [4, 9, 5], [2, 4, 11], [6, 2, 10], [8, 6, 7], [9, 8, 1],
    ];
    let mut vertices = [Vec3::ZERO; 42];
    for (v, c) in vertices.iter_mut().zip(CORNERS) {
        *v = Vec3::from(c).normalize();
    }
    let mut edges: Vec<(u32, u32)> = Vec::with_capacity(30);
    let mut triangles = [[0; 3]; 80];
    for (face, [a, b, c]) in FACES.into_iter().enumerate() {
        let [ab, bc, ca] = [(a, b), (b, c), (c, a)].map(|(p, q)| {
            let edge = (p.min(q), p.max(q));
            let at = edges.iter().position(|e| *e == edge).unwrap_or_else(|| {
                edges.push(edge);
                edges.len() - 1
            });
            vertices[12 + at] = (vertices[p as usize] + vertices[q as usize]).normalize();
            12 + to_u32(at)
        });
        triangles[4 * face..4 * face + 4].copy_from_slice(&[[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]);
    }
    (vertices, triangles)
}
