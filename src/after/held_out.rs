//! How well photographs that were left out are foretold: each is rendered with the materials in the light that was found, and held
//! against what the camera saw. Nothing was made of these photographs, so that this is a fair judge where no truth is known.
//!
//! Compared are sRGB values of pixels that show the mesh and that the mask does not ignore. How a photograph that was left out was
//! exposed is not known: where exposures are solved for, each rendering is darkened towards its corners as the camera does, and
//! brought to the photograph's exposure by the median of their ratios.

use glam::{UVec2, Vec3};

use super::finished::{Finished, Over};
use super::picture::{Light, as_decoded, lighting, with_shares};
use crate::base::Result;
use crate::codec::images::to_srgb;
use crate::light::luma;
use crate::render::pictures::PictureErrors;
use crate::render::relight::Rendering;
use crate::render::{Lighting, relight};
use crate::scene::Material;
use crate::scene::evidence::Evidence;
use crate::scene::frame::LinearImage;
use crate::scene::vignetting::Vignetting;
use crate::stages::decode::Exposure;

/// How well photographs that were left out are foretold.
#[derive(Debug, Clone, PartialEq, Default)]
pub(crate) struct HeldOut {
    /// The photographs that were compared.
    pub frames: usize,
    /// The photographs that could not be read, each with the reason.
    pub unread: Vec<(String, String)>,
    /// The estimates by name, the run's own first, and their errors.
    pub estimates: Vec<(&'static str, PictureErrors)>,
}

/// The least luminance at which exposures are compared.
const DARK: f32 = 0.004;

/// Compares the photographs that were left out with renderings of a finished run, of `beside`, and of the mean radiance of every
/// triangle as it is; `None` if none was left out or no light is known to render in.
pub(super) fn held_out(over: Over<'_>, beside: Option<&[Material]>) -> Result<Option<HeldOut>> {
    let Over { pipeline, finished: Finished { scene, materials, light, frozen, .. }, bvh, visibility } = over;
    let Some(light) = light.filter(|_| !scene.held_out.is_empty()) else { return Ok(None) };
    let (mesh, up) = (&scene.mesh, pipeline.scene.zenith());
    let lit = with_shares(light, up, visibility);
    let bare = Lighting { background: Vec3::NAN, ..lighting(Light::None, up.as_dvec3())? };
    let mean =
        |row: &[f32; Evidence::LEN]| Material { kd: Evidence::from_array(*row).mean_radiance, ks: [0.0; 3], r: 1.0 };
    let mut estimates: Vec<(&str, Vec<Material>, &Lighting)> = vec![
        ("estimate", materials.rows.iter().copied().map(Material::from).collect(), &lit),
        ("mean radiance", materials.evidence.iter().map(mean).collect(), &bare),
    ];
    estimates.extend(beside.map(|beside| ("beside", beside.to_vec(), &lit)));
    let none = estimates.iter().map(|(name, ..)| (*name, PictureErrors::default())).collect();
    let mut told = HeldOut { estimates: none, ..HeldOut::default() };
    let decode = scene.decode(pipeline);
    for posed in &scene.held_out {
        let photograph = match decode.read(posed, pipeline.run.memory.0) {
            Ok(photograph) => photograph,
            Err(why) => {
                told.unread.push((posed.name.clone(), why.to_string()));
                continue;
            }
        };
        let frame = as_decoded(pipeline, posed);
        let rendered = estimates.iter().map(|(_, estimate, light)| relight(mesh, bvh, estimate, &frame, light));
        let lens = frozen.state().vignetting_of(posed);
        let rendered = rendered.map(|rendering| Ok(through(lens, rendering?)));
        let rendered: Vec<Rendering> = rendered.collect::<Result<_>>()?;
        for (found, (_, errors)) in rendered.iter().zip(&mut told.estimates) {
            let gain = if pipeline.decode.exposure == Exposure::Solve { gain(&photograph, found) } else { 1.0 };
            // What the mesh covers is what the run's own rendering shows.
            errors.merge(&compared(&photograph, &rendered[0], found, gain));
        }
        told.frames += 1;
    }
    Ok(Some(told))
}

/// A rendering as a lens shows it.
fn through(lens: Vignetting, mut rendering: Rendering) -> Rendering {
    let size = UVec2::new(rendering.width, rendering.height);
    for (at, rgb) in (0..).zip(&mut rendering.rgb) {
        let shown = lens.at_pixel(UVec2::new(at % size.x, at / size.x), size);
        *rgb = rgb.map(|v| v * shown);
    }
    rendering
}

/// The errors of a rendering that is multiplied by `gain`, where `shown` is a number.
fn compared(photograph: &LinearImage, shown: &Rendering, found: &Rendering, gain: f32) -> PictureErrors {
    let (width, height) = (found.width as usize, found.height as usize);
    PictureErrors::of(width, height, |y, wanted, rendered| {
        for at in y * width..(y + 1) * width {
            let pixel = photograph.pixel(at).filter(|_| shown.rgb[at].iter().all(|v| v.is_finite()));
            wanted.push(pixel.map_or([f32::NAN; 3], |pixel| pixel.rgb.map(to_srgb)));
            rendered.push(found.rgb[at].map(|v| to_srgb(v * gain)));
        }
    })
}

/// The median ratio of a photograph's luminance to a rendering's, over pixels that are neither dark nor clipped.
fn gain(photograph: &LinearImage, found: &Rendering) -> f32 {
    let ratio = |at: usize| {
        let pixel = photograph.pixel(at).filter(|pixel| !pixel.clipped)?;
        let (wanted, found) = (luma(pixel.rgb), luma(found.rgb[at]));
        (wanted > DARK && found > DARK).then(|| wanted / found)
    };
    let mut ratios: Vec<f32> = (0..found.rgb.len()).filter_map(ratio).collect();
    let middle = ratios.len() / 2;
    if ratios.is_empty() { 1.0 } else { *ratios.select_nth_unstable_by(middle, f32::total_cmp).1 }
}
