//! The pixels of a triangle that show it alone: away from silhouettes and creases, where a pixel shows some of each side.

use glam::{DVec2, UVec2, Vec3};

use crate::base::convert::{Cut, to_f32};
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::scene::view::View;
use crate::trace::{Bvh, Hit, tile};

/// Pixels of a triangle that are tried, at most: a packet of rays.
const TRIED: usize = 16;

/// How far from a pixel its neighbours are tried, in pixels.
const APART: f64 = 1.5;

/// The neighbours that are tried.
const NEIGHBOURS: [DVec2; 4] =
    [DVec2::new(-APART, 0.0), DVec2::new(APART, 0.0), DVec2::new(0.0, -APART), DVec2::new(0.0, APART)];

/// The farthest that a neighbour's surface may lie from the triangle's plane, in pixels' breadths there.
const DEEP: f32 = 2.0;

/// The cosine of the largest angle to a neighbour's surface that is no crease.
const CREASE: f32 = 0.7;

/// The least cosine between a triangle's normal and the way to the camera.
const GRAZING: f32 = 0.15;

/// A worker's buffers, kept from triangle to triangle.
#[derive(Debug, Default)]
pub(crate) struct Trial {
    pixels: Vec<UVec2>,
    directions: Vec<Vec3>,
    hits: Vec<Hit>,
    around: Vec<Hit>,
}

impl Trial {
    /// The pixels of a view, spread over a triangle, that show it alone.
    pub(super) fn pixels(&mut self, view: &View, mesh: &Mesh, bvh: &Bvh, t: TriangleId) -> &[UVec2] {
        self.pixels.clear();
        if let Some(normal) = mesh.normal(t) {
            self.project(view, mesh, t, normal);
            self.keep_seen(view, mesh, bvh, t, normal);
        }
        &self.pixels
    }

    /// Finds the pixels that lie within the projected triangle, or a lattice of them where they are many.
    fn project(&mut self, view: &View, mesh: &Mesh, t: TriangleId, normal: Vec3) {
        let corners = mesh.corners(t);
        let towards = (view.centre() - (corners[0] + corners[1] + corners[2]) / 3.0).normalize_or_zero();
        if normal.dot(towards) < GRAZING {
            return;
        }
        let [Some(a), Some(b), Some(c)] = corners.map(|corner| view.project(corner)) else { return };
        let size = view.size().as_dvec2();
        let (low, high) = (a.min(b).min(c).max(DVec2::ZERO), a.max(b).max(c).min(size));
        let area = cross(b - a, c - a);
        if low.cmpge(high).any() || !area.is_finite() || area == 0.0 {
            return;
        }
        let step = (area.abs() / 2.0 / TRIED as f64).sqrt().max(1.0);
        let inside = |p: DVec2| {
            let sides = [cross(b - a, p - a), cross(c - b, p - b), cross(a - c, p - c)];
            sides.iter().all(|side| side * area.signum() >= 0.0)
        };
        let mut y = low.y + 0.5 * (step - 1.0);
        while y < high.y && self.pixels.len() < TRIED {
            let mut x = low.x + 0.5 * (step - 1.0);
            while x < high.x && self.pixels.len() < TRIED {
                let pixel = UVec2::new(u32::cut(x), u32::cut(y));
                if inside(pixel.as_dvec2() + 0.5) && pixel.cmplt(view.size()).all() {
                    self.pixels.push(pixel);
                }
                x += step;
            }
            y += step;
        }
    }

    /// Keeps the pixels that see the triangle, and around which nothing else is seen but what goes on from it.
    fn keep_seen(&mut self, view: &View, mesh: &Mesh, bvh: &Bvh, t: TriangleId, normal: Vec3) {
        let Trial { pixels, directions, hits, around } = self;
        let cast = |directions: &[Vec3], hits: &mut Vec<Hit>| {
            hits.clear();
            hits.resize(directions.len(), Hit::MISS);
            tile::cast(bvh, view.centre(), directions, hits);
        };
        directions.clear();
        directions.extend(pixels.iter().map(|pixel| view.direction(pixel.as_dvec2() + 0.5)));
        cast(directions, hits);
        let seen: Vec<(UVec2, Vec3, f32)> = pixels
            .iter()
            .zip(&*directions)
            .zip(&*hits)
            .filter(|(_, hit)| hit.is_some() && hit.triangle == t)
            .map(|((&pixel, &direction), hit)| (pixel, direction, hit.t))
            .collect();
        directions.clear();
        for (pixel, ..) in &seen {
            let at = pixel.as_dvec2() + 0.5;
            directions.extend(NEIGHBOURS.iter().map(|by| view.direction(at + *by)));
        }
        cast(directions, around);
        pixels.clear();
        let neighbours = directions.chunks(NEIGHBOURS.len()).zip(around.chunks(NEIGHBOURS.len()));
        for ((pixel, middle, t_here), (directions, hits)) in seen.into_iter().zip(neighbours) {
            let here = middle * t_here;
            let goes_on = |(direction, hit): (&Vec3, &Hit)| {
                if hit.is_some() && hit.triangle == t {
                    return true;
                }
                let breadth = (*direction - middle).length() * t_here / to_f32(APART);
                let off = (*direction * hit.t - here).dot(normal).abs();
                let turned = hit.is_some().then(|| mesh.normal(hit.triangle)).flatten();
                off <= DEEP * breadth && turned.is_some_and(|turned| turned.dot(normal) >= CREASE)
            };
            if directions.iter().zip(hits).all(goes_on) {
                pixels.push(pixel);
            }
        }
    }
}

/// The third component of the cross product.
fn cross(a: DVec2, b: DVec2) -> f64 {
    a.x * b.y - a.y * b.x
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;

    /// A floor of two triangles from -1 to 1, seen from above in 100 x 100 pixels of which it takes 80 x 80; a roof over half
    /// of it, and a wall at its edge.
    fn seen(more: &[[DVec3; 3]]) -> Vec<UVec2> {
        let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let floor = [corner(-1.0, -1.0), corner(1.0, -1.0), corner(1.0, 1.0), corner(-1.0, 1.0)];
        let vertices: Vec<DVec3> = floor.into_iter().chain(more.iter().flatten().copied()).collect();
        let others = (0..more.len() as u32).map(|i| [3 * i + 4, 3 * i + 5, 3 * i + 6]);
        let mesh = Mesh::new(&vertices, [[0, 1, 2], [0, 2, 3]].into_iter().chain(others).collect()).unwrap();
        let camera = Camera { width: 100, height: 100, lens: Lens::pinhole(DVec2::splat(400.0), DVec2::splat(50.0)) };
        let view = View::new(camera, &Pose::look_at(DVec3::Z * 10.0, DVec3::ZERO, DVec3::Y), &mesh);
        let mut trial = Trial::default();
        trial.pixels(&view, &mesh, &Bvh::build(&mesh), TriangleId(0)).to_vec()
    }

    #[test]
    fn pixels_are_spread_over_a_triangle_and_keep_away_from_silhouettes() {
        let all = seen(&[]);
        assert!((8..=TRIED).contains(&all.len()), "{all:?}");
        // The right and lower edges of the floor are silhouettes; its diagonal is none.
        assert!(all.iter().all(|p| p.x < 89 && p.y < 89), "{all:?}");
        let corner = |x: f64, y: f64| DVec3::new(x, y, 1.0);
        let roof = [corner(0.0, -2.0), corner(3.0, -2.0), corner(0.0, 3.0)];
        let beside = seen(&[roof]);
        assert!(!beside.is_empty() && beside.len() < all.len(), "{beside:?}");
        assert!(beside.iter().all(|p| p.x < 49), "{beside:?}");
    }

    #[test]
    fn what_turns_away_or_lies_behind_has_no_pixels() {
        let down = [DVec3::new(-2.0, -2.0, 5.0), DVec3::new(-2.0, 9.0, 5.0), DVec3::new(9.0, -2.0, 5.0)];
        assert_eq!(seen(&[down]), [UVec2::ZERO; 0], "hidden by what is seen from behind");
    }
}
