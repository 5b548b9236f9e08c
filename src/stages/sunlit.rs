//! Which pixels saw the mesh in the sun, and which in the shade. Most triangles lie wholly in one of them, which is found once;
//! on the others a ray towards the sun decides, pixel by pixel. A pixel beside one that saw the other is told from neither: it
//! may show a bit of both, or the soft edge of a shadow.

use glam::{UVec2, Vec3};
use rayon::prelude::*;

use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::scene::cells::Reach;
use crate::trace::visibility::{Shares, offset};
use crate::trace::{Bvh, PixelHit, parallel};

/// How much of a triangle the sun reaches.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Lit {
    None,
    Part,
    All,
}

/// A sun over a mesh.
#[derive(Debug)]
pub(crate) struct Sunlit {
    sun: Vec3,
    triangles: Vec<Lit>,
    offset: f32,
}

impl Sunlit {
    /// Bytes that are held for each triangle of the mesh.
    pub(crate) const BYTES_PER_TRIANGLE: u64 = size_of::<Lit>() as u64;

    /// Finds how much of each triangle a sun in this direction reaches.
    pub(crate) fn new(sun: Vec3, mesh: &Mesh, bvh: &Bvh) -> Sunlit {
        let shares = Shares::new(mesh, 0);
        let lit = |t: usize| match shares.sun(mesh, bvh, sun, TriangleId::at(t)) {
            0.0 => Lit::None,
            1.0 => Lit::All,
            _ => Lit::Part,
        };
        Sunlit { sun, triangles: (0..mesh.len()).into_par_iter().map(lit).collect(), offset: offset(mesh) }
    }
}

/// What reached the points that the pixels of a tile saw; reused from tile to tile.
#[derive(Debug, Default)]
pub(crate) struct TileReach {
    size: UVec2,
    /// Row by row.
    pixels: Vec<Reach>,
    /// Where the rays towards the sun start, and the pixels that they are for.
    origins: Vec<Vec3>,
    asked: Vec<usize>,
    dark: Vec<bool>,
}

impl TileReach {
    /// Bytes of memory held per pixel of the largest tile.
    pub(crate) const BYTES_PER_PIXEL: u64 =
        2 * (size_of::<Reach>() + size_of::<Vec3>() + size_of::<usize>() + size_of::<bool>()) as u64;

    /// Looks at a tile of this size, whose rays left `centre`.
    pub(crate) fn look(
        &mut self,
        sunlit: &Sunlit,
        (mesh, bvh): (&Mesh, &Bvh),
        centre: Vec3,
        size: UVec2,
        hits: impl Iterator<Item = PixelHit>,
    ) {
        self.size = size;
        self.pixels.clear();
        self.pixels.resize((size.x * size.y) as usize, Reach::Untold);
        self.origins.clear();
        self.asked.clear();
        for PixelHit { pixel, direction, hit } in hits.filter(|ray| ray.hit.is_some()) {
            let Some(normal) = mesh.normal(hit.triangle).filter(|normal| normal.dot(direction) < 0.0) else { continue };
            let at = (pixel.y * size.x + pixel.x) as usize;
            match sunlit.triangles[hit.triangle.index()] {
                Lit::None => self.pixels[at] = Reach::Shade,
                Lit::All => self.pixels[at] = Reach::Sun,
                Lit::Part => {
                    self.origins.push(centre + direction * hit.t + normal * sunlit.offset);
                    self.asked.push(at);
                }
            }
        }
        self.dark.clear();
        self.dark.resize(self.origins.len(), false);
        parallel::occluded(bvh, sunlit.sun, &self.origins, &mut self.dark);
        for (&at, dark) in self.asked.iter().zip(&self.dark) {
            self.pixels[at] = if *dark { Reach::Shade } else { Reach::Sun };
        }
    }

    /// What reached the point that a pixel of the tile saw, where the pixels around it saw the same.
    pub(crate) fn at(&self, pixel: UVec2) -> Reach {
        let own = self.pixels[(pixel.y * self.size.x + pixel.x) as usize];
        let (from, to) = (pixel.saturating_sub(UVec2::ONE), (pixel + 1).min(self.size - 1));
        let alike = (from.y..=to.y).all(|y| {
            let row = (y * self.size.x) as usize;
            self.pixels[row + from.x as usize..=row + to.x as usize].iter().all(|reach| *reach == own)
        });
        if alike { own } else { Reach::Untold }
    }
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;
    use crate::scene::view::{Tile, View};
    use crate::trace::TileRays;

    /// A floor of one square, seen from above, half of it in the shadow of a wall that the camera sees from the edge.
    fn scene() -> (Mesh, View) {
        let corners = [[-2.0, -2.0, 0.0], [2.0, -2.0, 0.0], [2.0, 2.0, 0.0], [-2.0, 2.0, 0.0]];
        let wall = [[-1.0, -9.0, 0.0], [-1.0, 9.0, 0.0], [-1.0, 9.0, 1.0], [-1.0, -9.0, 1.0]];
        let vertices: Vec<DVec3> = corners.into_iter().chain(wall).map(DVec3::from).collect();
        let mesh = Mesh::new(&vertices, vec![[0, 1, 2], [0, 2, 3], [4, 5, 6], [4, 6, 7]]).unwrap();
        let lens = Lens::pinhole(DVec2::splat(400.0), DVec2::splat(20.0));
        // A pixel is a tenth wide.
        let pose = Pose::look_at(DVec3::new(0.0, 0.0, 40.0), DVec3::ZERO, DVec3::Y);
        let view = View::new(Camera { width: 40, height: 40, lens }, &pose, &mesh);
        (mesh, view)
    }

    #[test]
    fn pixels_in_the_sun_and_in_the_shade_are_told_apart_and_those_at_the_edge_are_not() {
        let (mesh, view) = scene();
        let bvh = Bvh::build(&mesh);
        // From the left, 45 degrees high: the shadow reaches from x = -1 to 0.
        let sun = Vec3::new(-1.0, 0.0, 1.0).normalize();
        let sunlit = Sunlit::new(sun, &mesh, &bvh);
        assert_eq!(sunlit.triangles[..2], [Lit::Part; 2]);
        let (mut rays, mut reach) = (TileRays::default(), TileReach::default());
        for side in [40, 7] {
            let mut all = vec![Reach::Untold; 40 * 40];
            for tile in view.tiles(side) {
                let cast = tile.with_border(view.size());
                let corner = UVec2::new(cast.x, cast.y);
                let hits = rays.cast(&view, &bvh, cast);
                reach.look(&sunlit, (&mesh, &bvh), view.centre(), UVec2::new(cast.width, cast.height), hits.clone());
                for ray in hits.filter(|ray| tile.holds(ray.pixel + corner)) {
                    all[cast.position(ray.pixel, 40)] = reach.at(ray.pixel);
                }
            }
            // Columns 0 to 39 have x from -1.95 to 1.95; the wall's top is seen at its foot's side.
            for row in 1..39 {
                let columns = &all[row * 40..][..40];
                assert!(columns[1..7].iter().all(|reach| *reach == Reach::Sun), "{side} {row}: {columns:?}");
                assert!(columns[12..18].iter().all(|reach| *reach == Reach::Shade), "{side} {row}: {columns:?}");
                assert!(columns[19..=20].iter().all(|reach| *reach == Reach::Untold), "{side} {row}: {columns:?}");
                assert!(columns[22..39].iter().all(|reach| *reach == Reach::Sun), "{side} {row}: {columns:?}");
            }
        }
        let whole = Tile { x: 0, y: 0, width: 40, height: 40 };
        assert_eq!(whole.with_border(view.size()), whole);
    }
}
