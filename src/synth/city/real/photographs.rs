//! Photographs of a town in the real world.

use std::path::Path;

use glam::Vec3;
use rayon::prelude::*;

use super::ambient::ambient;
use super::camera::developed;
use super::shade::{COLUMNS, Lit, Point, split};
use super::sky::Sky;
use crate::base::Result;
use crate::base::convert::to_u32;
use crate::cache::Cached;
use crate::codec::images;
use crate::render::relight::Rendering;
use crate::scene::frame::Frame;
use crate::scene::view::{Tile, View};
use crate::synth::city::missing::Missing;
use crate::synth::city::{CityConfig, suns};
use crate::trace::{PixelHit, TileRays, parallel, visibility};

/// The best quality of a photograph's file.
const QUALITY: u8 = 80;

/// Edge of the tiles that rays are cast in, pixels.
const SIDE: u32 = 4;

/// Takes the `k`-th photographs that are listed, and writes them into a folder. The rows are the town's.
///
/// # Errors
/// A file cannot be written; `Error::Interrupted` where `stop` says so.
pub(in crate::synth::city) fn take(
    dir: &Path,
    config: &CityConfig,
    missing: &Missing<'_>,
    town: &Cached,
    rows: &[[f32; COLUMNS]],
    stop: &dyn Fn() -> bool,
) -> Result<()> {
    for (at, light) in suns::lights(config).into_iter().enumerate() {
        let of_sun: Vec<_> = missing.frames.iter().filter(|(k, _)| suns::of_frame(config, *k) == at).collect();
        if of_sun.is_empty() {
            continue;
        }
        let (sun, sky) = (light.sun, Sky::new(light.sun.direction, light.sky));
        let (mesh, bvh, offset) = (&town.mesh, &town.bvh, visibility::offset(&town.mesh));
        let kd = |t: usize| Vec3::from(split(&rows[t]).0.kd);
        let ambient = ambient(mesh, bvh, kd, (&sun, &sky), offset, stop)?;
        let lit = Lit { mesh, bvh, rows, sun, sky, ambient, offset };
        for (k, frame) in of_sun {
            missing.take(|| {
                let picture = picture(&lit, frame).shrink(config.supersampling);
                let pixels = developed(&picture.rgb, picture.width as usize);
                let (path, size) = (dir.join(&frame.name), [config.width, config.height]);
                let quality = config.jpeg_quality.min(QUALITY);
                images::write_jpeg_taken(&path, &pixels, size, quality, suns::taken(config, *k))
            })?;
        }
    }
    Ok(())
}

/// The linear radiance of a frame. It does not depend on the number of threads.
fn picture(lit: &Lit<'_>, frame: &Frame) -> Rendering {
    let view = View::new((*frame.camera).clone(), &frame.pose, lit.mesh);
    let (width, height) = (frame.camera.width, frame.camera.height);
    let mut rgb = vec![[0.0; 3]; width as usize * height as usize];
    // A band of tiles is contiguous in the image.
    rgb.par_chunks_mut((width * SIDE) as usize).enumerate().for_each(|(band, out)| {
        let mut rays = TileRays::default();
        let (mut points, mut origins, mut dark): (Vec<(usize, Point)>, Vec<Vec3>, Vec<bool>) = Default::default();
        let y = to_u32(band) * SIDE;
        for x in (0..width).step_by(SIDE as usize) {
            let tile = Tile { x, y, width: SIDE.min(width - x), height: SIDE.min(height - y) };
            let inside = Tile { y: 0, ..tile };
            points.clear();
            origins.clear();
            for PixelHit { pixel, direction, hit } in rays.cast(&view, lit.bvh, tile) {
                let at = inside.position(pixel, width);
                match lit.point(view.centre(), direction, &hit) {
                    Some(point) => {
                        origins.push(lit.start(&point));
                        points.push((at, point));
                    }
                    None => out[at] = lit.beyond(direction).to_array(),
                }
            }
            dark.clear();
            dark.resize(origins.len(), false);
            parallel::occluded(lit.bvh, lit.sun.direction, &origins, &mut dark);
            for ((at, point), dark) in points.iter().zip(&dark) {
                let is_lit = !dark && point.normal.dot(lit.sun.direction) > 0.0;
                out[*at] = lit.radiance(point, is_lit).to_array();
            }
        }
    });
    Rendering { width, height, rgb }
}
