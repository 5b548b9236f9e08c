//! Pictures of a finished run: a frame relit, from where its photograph was taken.

use std::path::Path;

use glam::{DMat3, DVec3, Vec3};

use super::finished::{Finished, writable};
use crate::base::{Array, Error, Result};
use crate::codec::images::{Size, read_image, to_srgb8, write_png};
use crate::flow::pool;
use crate::pipeline::Pipeline;
use crate::render::relight::Rendering;
use crate::render::{Lighting, relight};
use crate::scene::Material;
use crate::scene::frame::{Frame, LinearImage};
use crate::scene::light::Sun;
use crate::stages::scene_light::SunAndSky;
use crate::trace::sky_visibility;
use crate::trace::visibility::SKY_RAYS;

/// What the scene is lit by.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Light {
    /// Nothing: the diffuse colours as they are.
    None,
    /// A white sun that casts shadows, and a white sky.
    Sun {
        /// The sun's height above the plane across `[scene] up`, degrees.
        elevation_deg: f64,
        /// The sun's direction about `[scene] up`, degrees.
        azimuth_deg: f64,
        /// The sky's radiance.
        sky: f32,
    },
}

/// What triangles without a material are shown as.
const UNKNOWN: Material = Material { kd: [0.216; 3], ks: [0.0; 3], r: 1.0 };

/// Renders a frame of a finished run and writes a PNG; with the photograph to its left if `beside`.
///
/// # Errors
/// No finished run, no frame of that name, a sky or angles that are no numbers, anything that cannot be read or written.
pub(crate) fn render(pipeline: &Pipeline, frame: &str, light: Light, beside: bool, out: &Path) -> Result<()> {
    writable(pipeline, out)?;
    let Finished { scene, materials, .. } = Finished::open(pipeline)?;
    let (_, posed) = scene.frame(frame)?;
    let frame = as_decoded(pipeline, posed);
    let size = Size { width: frame.camera.width, height: frame.camera.height };
    let rows = materials.rows.iter().map(|row| if row[0].is_nan() { UNKNOWN } else { Material::from(*row) });
    let mut rows: Vec<Material> = rows.collect();
    let bvh = scene.bvh();
    let mut lighting = lighting(light, DVec3::from(pipeline.scene.up))?;
    let picture = pool::share(pipeline.run.threads(), || {
        if light == Light::None {
            // A black sun and a white sky that all see: diffuse colours.
            rows.iter_mut().for_each(|m| m.ks = [0.0; 3]);
        } else {
            let all = 0..scene.mesh.len();
            lighting.visibility = sky_visibility(&scene.mesh, &bvh, lighting.up, SKY_RAYS, all).into();
        }
        relight(&scene.mesh, &bvh, &rows, &frame, &lighting)
    })??;
    let pixels: Vec<[u8; 3]> = picture.rgb.iter().map(|p| p.map(to_srgb8)).collect();
    if !beside {
        return write_png(out, &pixels, size.width, size.height);
    }
    let photograph =
        read_image(&pipeline.scene.images.join(&frame.name), size, &pipeline.decode.curve(), pipeline.run.memory.0)?;
    write_png(out, &side_by_side(&photograph, &picture), 2 * size.width, size.height)
}

/// A frame as it is decoded: with the camera of the image that is left of its photograph.
pub(super) fn as_decoded(pipeline: &Pipeline, posed: &Frame) -> Frame {
    Frame { camera: posed.camera.down_scaled(pipeline.decode.downscale).into(), ..posed.clone() }
}

/// A light over a scene whose zenith is `up`.
pub(super) fn lighting(light: Light, up: DVec3) -> Result<Lighting> {
    let up = up.normalize();
    let Light::Sun { elevation_deg, azimuth_deg, sky } = light else {
        let sun = Sun { direction: up.as_vec3(), color: Vec3::ZERO };
        return Ok(Lighting { up: up.as_vec3(), background: Vec3::ZERO, ..Lighting::new(sun, Vec3::ONE) });
    };
    if !(elevation_deg.is_finite() && azimuth_deg.is_finite() && (0.0..=1.0).contains(&sky)) {
        return Err(Error::invalid("the sun's angles must be finite, and the sky's radiance must lie in [0, 1]"));
    }
    let x = up.any_orthonormal_vector();
    let axes = DMat3::from_cols(x, up.cross(x), up);
    let (a, e) = (azimuth_deg.to_radians(), elevation_deg.to_radians());
    let direction = axes * DVec3::new(a.cos() * e.cos(), a.sin() * e.cos(), e.sin());
    let sun = Sun { direction: direction.as_vec3().normalize(), color: Vec3::ONE };
    Ok(Lighting { up: up.as_vec3(), ..Lighting::new(sun, Vec3::splat(sky)) })
}

/// A sun and a sky over a scene whose zenith is `up`, with each triangle's share of the sky. Nothing lies behind the
/// mesh: those pixels are no numbers.
pub(super) fn with_shares(light: SunAndSky, up: Vec3, visibility: &Array<f32>) -> Lighting {
    let SunAndSky { sun, sky, bounce, .. } = light;
    Lighting { up, bounce, visibility: visibility.clone(), background: Vec3::NAN, ..Lighting::new(sun, sky) }
}

fn side_by_side(photograph: &LinearImage, picture: &Rendering) -> Vec<[u8; 3]> {
    let (width, height) = (picture.width as usize, picture.height as usize);
    let mut pixels = Vec::with_capacity(2 * width * height);
    for row in 0..height {
        let at = row * width..(row + 1) * width;
        pixels.extend(at.clone().map(|i| photograph.pixel(i).map_or([0; 3], |p| p.rgb.map(to_srgb8))));
        pixels.extend(picture.rgb[at].iter().map(|p| p.map(to_srgb8)));
    }
    pixels
}
