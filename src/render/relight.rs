//! A frame rendered from a mesh with materials: one ray a pixel through its centre, flat triangles, the sun's shadows.

use glam::Vec3;
use rayon::prelude::*;

use super::environment::{self, Lighting};
use crate::base::convert::to_u32;
use crate::base::ids::TriangleId;
use crate::base::{Error, Result};
use crate::scene::frame::Frame;
use crate::scene::reflectance::LobeFrame;
use crate::scene::view::{Tile, View};
use crate::scene::{Material, Mesh};
use crate::trace::{Bvh, Hit, PixelHit, TileRays, parallel, visibility};

/// A rendered image: linear radiance, not clipped.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Rendering {
    /// Columns.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Linear RGB, rows from the top.
    pub rgb: Vec<[f32; 3]>,
}

/// Edge of the tiles that rays are cast in, pixels: the sixteen rays that go together.
const SIDE: u32 = 4;

/// Renders the frame's view of the mesh with one material for each triangle. Both sides of a triangle are seen. Materials
/// that are not finite come out as NaN. The picture does not depend on the number of threads.
///
/// # Errors
/// The number of materials, or of shares of the sky, is not the number of triangles.
pub(crate) fn relight(
    mesh: &Mesh,
    bvh: &Bvh,
    materials: &[Material],
    frame: &Frame,
    lighting: &Lighting,
) -> Result<Rendering> {
    if materials.len() != mesh.len() {
        let words = format!("{} materials for {} triangles: there must be one for each", materials.len(), mesh.len());
        return Err(Error::invalid(words));
    }
    if !lighting.visibility.is_empty() && lighting.visibility.len() != mesh.len() {
        let n = lighting.visibility.len();
        return Err(Error::invalid(format!(
            "{n} shares of the sky for {} triangles: there must be one for each",
            mesh.len()
        )));
    }
    let view = View::new((*frame.camera).clone(), &frame.pose, mesh);
    let (width, height) = (frame.camera.width, frame.camera.height);
    let mut rgb = vec![[0.0; 3]; width as usize * height as usize];
    let scene = Shading { mesh, bvh, materials, lighting, offset: visibility::offset(mesh) };
    // A band of tiles is contiguous in the image.
    rgb.par_chunks_mut((width * SIDE) as usize).enumerate().for_each(|(band, out)| {
        let (mut rays, mut sunny) = (TileRays::default(), Sunny::default());
        let y = to_u32(band) * SIDE;
        for x in (0..width).step_by(SIDE as usize) {
            let tile = Tile { x, y, width: SIDE.min(width - x), height: SIDE.min(height - y) };
            let inside = Tile { y: 0, ..tile };
            for PixelHit { pixel, direction, hit } in rays.cast(&view, bvh, tile) {
                let at = inside.position(pixel, width);
                out[at] = scene.shaded(&hit, view.centre(), direction, at, &mut sunny).to_array();
            }
            scene.add_sun(&mut sunny, out);
        }
    });
    Ok(Rendering { width, height, rgb })
}

struct Shading<'a> {
    mesh: &'a Mesh,
    bvh: &'a Bvh,
    materials: &'a [Material],
    lighting: &'a Lighting,
    offset: f32,
}

/// The pixels of a tile that face the sun.
#[derive(Default)]
struct Sunny {
    /// Where rays to the sun start, for each face.
    origins: Vec<Vec3>,
    faces: Vec<Face>,
    /// Whether each face lies in shadow.
    dark: Vec<bool>,
}

/// A surface as a pixel sees it.
struct Face {
    /// The pixel's position in the band.
    at: usize,
    triangle: TriangleId,
    normal: Vec3,
    /// The unit vector to the eye.
    wo: Vec3,
}

impl Shading<'_> {
    /// The radiance of a pixel in the shade. A face that the sun may light is added to `sunny`.
    fn shaded(&self, hit: &Hit, eye: Vec3, direction: Vec3, at: usize, sunny: &mut Sunny) -> Vec3 {
        let Some(normal) = (hit.triangle != TriangleId::NONE).then(|| self.mesh.normal(hit.triangle)).flatten() else {
            return self.lighting.background;
        };
        let normal = if normal.dot(direction) > 0.0 { -normal } else { normal };
        let wo = -direction;
        if self.lighting.sun.direction.dot(normal) > 0.0 {
            sunny.origins.push(eye + direction * hit.t + normal * self.offset);
            sunny.faces.push(Face { at, triangle: hit.triangle, normal, wo });
        }
        self.lighting.ambient(hit.triangle, &self.materials[hit.triangle.index()], normal.dot(wo))
    }

    /// Adds the sun's light to the faces it reaches, and empties `sunny`.
    fn add_sun(&self, sunny: &mut Sunny, out: &mut [[f32; 3]]) {
        let sun = &self.lighting.sun;
        sunny.dark.resize(sunny.origins.len(), false);
        parallel::occluded(self.bvh, sun.direction, &sunny.origins, &mut sunny.dark);
        for (face, _) in sunny.faces.iter().zip(&sunny.dark).filter(|(_, dark)| !**dark) {
            let m = &self.materials[face.triangle.index()];
            let lit = environment::sunlit(sun, m, &LobeFrame::new(face.normal), face.wo);
            out[face.at] = (Vec3::from(out[face.at]) + lit).to_array();
        }
        sunny.origins.clear();
        sunny.faces.clear();
    }
}

impl Rendering {
    /// The image averaged over squares of `n` by `n` pixels. Columns and rows past a multiple of `n` are left off.
    pub(crate) fn shrink(&self, n: u32) -> Rendering {
        let (width, height) = (self.width / n.max(1), self.height / n.max(1));
        let average = |x: u32, y: u32| {
            let square = (0..n * n).map(|k| ((y * n + k / n) * self.width + x * n + k % n) as usize);
            (square.map(|i| Vec3::from(self.rgb[i])).sum::<Vec3>() / (n * n) as f32).to_array()
        };
        let rgb = (0..width * height).map(|i| average(i % width, i / width)).collect();
        Rendering { width, height, rgb }
    }
}
