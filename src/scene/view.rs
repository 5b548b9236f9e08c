//! A frame among the mesh's triangles: the rays of its pixels, in the mesh's coordinates.

use glam::{DMat3, DVec2, DVec3, UVec2, Vec3};

use super::Mesh;
use super::camera::Camera;
use super::pose::Pose;

/// A camera placed among the mesh's triangles.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct View {
    camera: Camera,
    to_world: DMat3,
    centre: Vec3,
}

/// A rectangle of pixels.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Tile {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
}

impl Tile {
    /// The position in the image (`row * image width + column`) of the tile's pixel at `x` (column) and `y` (row).
    pub(crate) fn position(self, pixel: UVec2, image_width: u32) -> usize {
        (self.y + pixel.y) as usize * image_width as usize + (self.x + pixel.x) as usize
    }

    /// The tile with the pixels around it, as far as an image of this size has them.
    pub(crate) fn with_border(self, image: UVec2) -> Tile {
        let (x, y) = (self.x.saturating_sub(1), self.y.saturating_sub(1));
        let (right, bottom) = ((self.x + self.width + 1).min(image.x), (self.y + self.height + 1).min(image.y));
        Tile { x, y, width: right - x, height: bottom - y }
    }

    /// Whether a pixel of the image lies in the tile.
    pub(crate) fn holds(self, pixel: UVec2) -> bool {
        let inside = |at: u32, from: u32, length: u32| at.checked_sub(from).is_some_and(|at| at < length);
        inside(pixel.x, self.x, self.width) && inside(pixel.y, self.y, self.height)
    }

    /// Tiles of at most `side` x `side` pixels that cover this one, row by row.
    pub(crate) fn split(self, side: u32) -> impl Iterator<Item = Tile> {
        let (side, Tile { x, y, width, height }) = (side.max(1), self);
        let corner = move |start: u32, length: u32| (start..start + length).step_by(side as usize);
        let row = move |top| corner(x, width).map(move |left| (left, top));
        corner(y, height).flat_map(row).map(move |(left, top)| Tile {
            x: left,
            y: top,
            width: side.min(x + width - left),
            height: side.min(y + height - top),
        })
    }
}

impl View {
    /// Places a camera; its pose is in the mesh file's coordinates.
    pub(crate) fn new(camera: Camera, pose: &Pose, mesh: &Mesh) -> View {
        let to_world = DMat3::from_quat(pose.rotation.inverse());
        View { camera, to_world, centre: (pose.centre() - mesh.origin).as_vec3() }
    }

    /// Centre of projection, relative to the mesh's origin.
    pub(crate) fn centre(&self) -> Vec3 {
        self.centre
    }

    /// Tiles of at most `side` x `side` pixels that cover the image, row by row.
    pub(crate) fn tiles(&self, side: u32) -> impl Iterator<Item = Tile> + use<> {
        Tile { x: 0, y: 0, width: self.camera.width, height: self.camera.height }.split(side)
    }

    /// Unit directions, in the world, through the centres of a tile's pixels, which are counted from the tile's corner;
    /// NaN where the lens sees nothing. `out` is overwritten.
    pub(crate) fn directions(&self, tile: Tile, pixels: &[UVec2], out: &mut Vec<Vec3>) {
        out.clear();
        out.extend(pixels.iter().map(|pixel| {
            let pixel = DVec2::new(f64::from(tile.x + pixel.x) + 0.5, f64::from(tile.y + pixel.y) + 0.5);
            self.direction(pixel)
        }));
    }

    /// The unit direction, in the world, that is seen at a point of the image; NaN where the lens sees nothing.
    pub(crate) fn direction(&self, at: DVec2) -> Vec3 {
        (self.to_world * self.camera.ray(at).unwrap_or(DVec3::NAN)).as_vec3()
    }

    /// Where in the image, or beside it, a point of the mesh is seen; `None` if the lens cannot see it.
    pub(crate) fn project(&self, point: Vec3) -> Option<DVec2> {
        self.camera.project(self.to_world.transpose() * (point - self.centre).as_dvec3())
    }

    /// The image's columns and rows.
    pub(crate) fn size(&self) -> UVec2 {
        UVec2::new(self.camera.width, self.camera.height)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::camera::Lens;

    fn view() -> View {
        let mesh = Mesh::new(&[DVec3::ZERO, DVec3::X, DVec3::Y].map(|v| v + 1e6), vec![[0, 1, 2]]).unwrap();
        let lens = Lens::pinhole(DVec2::splat(50.0), DVec2::new(35.0, 20.0));
        let eye = mesh.origin + DVec3::Z * 10.0;
        View::new(Camera { width: 70, height: 40, lens }, &Pose::look_at(eye, mesh.origin, DVec3::Y), &mesh)
    }

    #[test]
    fn tiles_cover_every_pixel_once() {
        let view = view();
        for side in [1, 7, 32, 100] {
            let mut seen = vec![0; 70 * 40];
            for tile in view.tiles(side) {
                let all = (0..tile.height).flat_map(|y| (0..tile.width).map(move |x| UVec2::new(x, y)));
                all.for_each(|p| seen[tile.position(p, 70)] += 1);
            }
            assert!(seen.iter().all(|&n| n == 1), "side {side}");
        }
    }

    #[test]
    fn what_is_seen_at_a_point_is_projected_there() {
        let view = view();
        for at in [DVec2::new(3.25, 4.5), DVec2::new(69.0, 1.0), DVec2::new(-4.0, 45.0)] {
            let point = view.centre() + view.direction(at) * 7.0;
            assert!(view.project(point).is_some_and(|found| found.distance(at) < 1e-3), "{at}");
        }
        assert_eq!(view.project(view.centre() + Vec3::Z), None, "behind the camera");
    }

    #[test]
    fn rays_leave_the_centre_of_pixels() {
        let (view, mut out) = (view(), Vec::new());
        let tile = Tile { x: 34, y: 19, width: 2, height: 2 };
        view.directions(tile, &[UVec2::ZERO, UVec2::X, UVec2::Y, UVec2::ONE], &mut out);
        assert!((view.centre() - Vec3::Z * 10.0).length() < 1e-5, "{}", view.centre());
        // The principal point is the corner of four pixels: their rays lie around straight down.
        assert!((out.iter().sum::<Vec3>() / 4.0).normalize().distance(Vec3::NEG_Z) < 1e-6);
        assert!(out[0].x < 0.0 && out[0].y > 0.0 && out[3].x > 0.0 && out[3].y < 0.0, "{out:?}");
    }
}
