//! How large the triangles of a mesh are in the frames, by the poses alone.

use glam::DVec2;
use rayon::prelude::*;

use crate::base::convert::to_f32;
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::scene::frame::Frame;
use crate::scene::view::View;

/// Frames that are looked at, at most, spread over all.
const FRAMES: usize = 48;

/// Triangles that are looked at, at most, spread over the mesh.
const TRIANGLES: usize = 400_000;

/// The pixels that each triangle usually has in the frames that it turns to, were nothing in between; 0 for a triangle that is in
/// none of them, and for those that were left out because there are many.
pub(crate) fn usual_pixels(mesh: &Mesh, frames: &[Frame], downscale: u32) -> Vec<f32> {
    let few = frames.len().min(FRAMES);
    let views: Vec<View> = (0..few)
        .map(|i| &frames[i * frames.len() / few])
        .map(|frame| View::new(frame.camera.down_scaled(downscale), &frame.pose, mesh))
        .collect();
    let every = mesh.len().div_ceil(TRIANGLES).max(1);
    let usual = |t: usize| {
        if !t.is_multiple_of(every) {
            return 0.0;
        }
        let mut sizes: Vec<f32> = views.iter().filter_map(|view| pixels(view, mesh, TriangleId::at(t))).collect();
        sizes.sort_unstable_by(f32::total_cmp);
        sizes.get(sizes.len() / 2).copied().unwrap_or(0.0)
    };
    (0..mesh.len()).into_par_iter().map(usual).collect()
}

/// The pixels of a triangle in a view that sees its front whole.
fn pixels(view: &View, mesh: &Mesh, t: TriangleId) -> Option<f32> {
    let corners = mesh.corners(t);
    let size = view.size().as_dvec2();
    mesh.normal(t).filter(|normal| normal.dot(view.centre() - corners[0]) > 0.0)?;
    let mut at = corners
        .iter()
        .filter_map(|&corner| view.project(corner).filter(|p| p.cmpge(DVec2::ZERO).all() && p.cmplt(size).all()));
    let (a, b, c) = (at.next()?, at.next()?, at.next()?);
    Some(to_f32((b - a).perp_dot(c - a).abs() / 2.0))
}

#[cfg(test)]
mod tests {
    use glam::DVec3;

    use super::*;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;

    #[test]
    fn a_triangle_has_the_pixels_that_the_poses_give_it() {
        // A triangle half a unit square in size, the same from behind, and one beside the picture.
        let corner = |x: f64, y: f64| DVec3::new(x, y, 0.0);
        let vertices = [corner(0.0, 0.0), corner(1.0, 0.0), corner(0.0, 1.0), corner(90.0, 0.0), corner(91.0, 0.0)];
        let mesh = Mesh::new(&vertices, vec![[0, 1, 2], [0, 2, 1], [3, 4, 2]]).unwrap();
        let camera = Camera { width: 100, height: 100, lens: Lens::pinhole(DVec2::splat(200.0), DVec2::splat(50.0)) };
        let frame = |height: f64| Frame {
            name: height.to_string(),
            camera: camera.clone().into(),
            pose: Pose::look_at(DVec3::Z * height, DVec3::ZERO, DVec3::Y),
        };
        let sizes = usual_pixels(&mesh, &[5.0, 10.0, 20.0].map(frame), 1);
        assert!((sizes[0] - 200.0).abs() < 0.1, "{sizes:?}: half of 20 x 20 pixels, in the middle frame");
        assert_eq!(sizes[1..], [0.0, 0.0]);
        assert!((usual_pixels(&mesh, &[frame(10.0)], 2)[0] - 50.0).abs() < 0.1);
        assert_eq!(usual_pixels(&mesh, &[], 1), [0.0; 3]);
    }
}
