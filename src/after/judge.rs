//! How the materials of a finished run relight, where the truth is known: frames rendered with both, in the light of the
//! photographs where that is known, and under other suns.

use std::path::Path;

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use super::finished::{Finished, Over};
use super::held_out::{HeldOut, held_out};
use super::picture::{Light, as_decoded, lighting, with_shares};
use crate::base::ids::TriangleId;
use crate::base::{Array, Error, Result};
use crate::codec::tables::npy;
use crate::flow::pool;
use crate::pipeline::Pipeline;
use crate::render::metrics::{MaterialErrors, compare, diffuse_guess};
use crate::render::pictures::PixelErrors;
use crate::render::{Lighting, relight};
use crate::scene::Material;
use crate::scene::evidence::{Evidence, Filled};
use crate::stages::scene_light::{SceneLight, SunAndSky};
use crate::trace::sky_visibility;
use crate::trace::visibility::SKY_RAYS;

/// The other suns: elevation and azimuth about `[scene] up`, degrees.
pub(crate) const SUNS: [(f64, f64); 4] = [(20.0, 60.0), (35.0, 150.0), (55.0, 290.0), (75.0, 0.0)];

/// The sky that they stand in where none is known.
const SKY: f32 = 0.2;

/// The errors of an estimate.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Judged {
    /// The estimate's name.
    pub name: &'static str,
    /// The errors of the components, over the triangles that were seen.
    pub errors: MaterialErrors,
    /// Peak signal-to-noise ratio of linear radiance, clipped to [0, 1], over the pixels that show them, dB: in the
    /// light of the photographs, where it is known.
    pub same: Option<f64>,
    /// Under each of [`SUNS`].
    pub suns: [f64; SUNS.len()],
}

/// What a finished run is judged by.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Judge<'a> {
    /// The truth, where it is known: `.npy` [F,7].
    pub truth: Option<&'a Path>,
    /// Another estimate to judge beside the run's: `.npy` [F,7].
    pub beside: Option<&'a Path>,
    /// The number of frames to render with the truth, spread over the flight.
    pub frames: usize,
}

/// Judges the materials of a finished run, and others beside it, by the truth and by the photographs that were left out.
///
/// # Errors
/// No finished run; neither a truth nor photographs that were left out, and a light to render them in; tables that cannot be read or have other triangles; no
/// triangle that was seen.
pub(crate) fn judge(pipeline: &Pipeline, judge: Judge<'_>) -> Result<(Vec<Judged>, Option<HeldOut>)> {
    let finished = Finished::open(pipeline)?;
    let read = |file: &Path| -> Result<Vec<Material>> {
        let rows: Vec<Material> = npy::read_rows(file)?.into_iter().map(Material::from).collect();
        let (found, triangles) = (rows.len(), finished.scene.mesh.len());
        if found != triangles {
            let words = format!("{}: {found} materials, for a mesh of {triangles} triangles", file.display());
            return Err(Error::invalid(words));
        }
        Ok(rows)
    };
    let (truth, beside) = (judge.truth.map(read).transpose()?, judge.beside.map(read).transpose()?);
    if truth.is_none() && finished.scene.held_out.is_empty() {
        return Err(Error::invalid(
            "there is nothing to judge by: give a --truth, or leave photographs out with [run] holdout = \"every 4th\" and run \
             again",
        ));
    }
    if truth.is_none() && finished.light.is_none() {
        return Err(Error::invalid(
            "no light is known to render the photographs in that were left out: set [light] mode = \"estimate\", or \"known\" and \
             its sun; a table of another run is judged with --beside",
        ));
    }
    pool::share(pipeline.run.threads(), || {
        let (scene, beside) = (&finished.scene, beside.as_deref());
        let (bvh, all) = (scene.bvh(), 0..scene.mesh.len());
        let visibility = sky_visibility(&scene.mesh, &bvh, pipeline.scene.zenith(), SKY_RAYS, all).into();
        let over = Over { pipeline, finished: &finished, bvh: &bvh, visibility: &visibility };
        let truth = truth.map(|truth| judged(over, &truth, beside, judge.frames)).transpose()?;
        Ok((truth.unwrap_or_default(), held_out(over, beside)?))
    })?
}

fn judged(over: Over<'_>, truth: &[Material], beside: Option<&[Material]>, frames: usize) -> Result<Vec<Judged>> {
    let Over { pipeline, finished: Finished { scene, materials, light, .. }, bvh, visibility } = over;
    let evidence: Vec<Evidence> = materials.evidence.iter().map(|row| Evidence::from_array(*row)).collect();
    let seen: Vec<bool> = evidence.iter().map(|e| e.filled == Filled::Observed).collect();
    if !seen.contains(&true) {
        return Err(Error::invalid("no triangle was seen: there is nothing to judge"));
    }
    let mesh = &scene.mesh;
    let mean: Vec<[f32; 3]> = evidence.iter().map(|e| e.mean_radiance).collect();
    let mut estimates = vec![
        ("estimate", materials.rows.iter().copied().map(Material::from).collect()),
        ("mean radiance as kd, ks 0, r 0.5", diffuse_guess(&mean)),
    ];
    if let Some(light) = light {
        let light = SceneLight::new(*light, mesh, bvh, pipeline.scene.up);
        estimates.push(("Lambertian in the known light", lambertian(&light, &mean)));
    }
    estimates.extend(beside.map(|beside| ("beside", beside.to_vec())));
    let errors: Vec<MaterialErrors> =
        estimates.iter().map(|(_, estimate)| compare(truth, estimate, &seen)).collect::<Result<_>>()?;

    // What is not to be compared is no number in the pictures of the truth.
    let nothing = Material::from([f32::NAN; Material::LEN]);
    let compared: Vec<Material> = truth.iter().zip(&seen).map(|(m, seen)| if *seen { *m } else { nothing }).collect();
    let lights = lights(pipeline, *light, visibility)?;
    let mut sums = vec![vec![PixelErrors::default(); lights.len()]; estimates.len()];
    let count = frames.clamp(1, scene.frames.len());
    for posed in (0..count).map(|i| &scene.frames[i * scene.frames.len() / count]) {
        let frame = as_decoded(pipeline, posed);
        for (at, light) in lights.iter().enumerate() {
            let wanted = relight(mesh, bvh, &compared, &frame, light)?;
            for ((_, estimate), sums) in estimates.iter().zip(&mut sums) {
                sums[at].add(&wanted.rgb, &relight(mesh, bvh, estimate, &frame, light)?.rgb);
            }
        }
    }
    let judged = estimates.iter().zip(errors).zip(sums).map(|(((name, _), errors), sums)| {
        let psnr: Vec<f64> = sums.iter().map(PixelErrors::psnr).collect();
        let (same, suns) = psnr.split_at(psnr.len() - SUNS.len());
        Judged { name, errors, same: same.first().copied(), suns: std::array::from_fn(|i| suns[i]) }
    });
    Ok(judged.collect())
}

/// The light of the photographs, if there is one, and then the other suns.
fn lights(pipeline: &Pipeline, known: Option<SunAndSky>, visibility: &Array<f32>) -> Result<Vec<Lighting>> {
    let sky = known.map_or(Vec3::splat(SKY), |light| light.sky);
    let over = |light| with_shares(light, pipeline.scene.zenith(), visibility);
    let others = SUNS.iter().map(|&(elevation_deg, azimuth_deg)| {
        let light = Light::Sun { elevation_deg, azimuth_deg, sky: SKY };
        lighting(light, DVec3::from(pipeline.scene.up)).map(|lighting| over(SunAndSky::new(lighting.sun, sky)))
    });
    known.map(|light| Ok(over(light))).into_iter().chain(others).collect()
}

/// Least squares of a matt surface in a known light: its mean radiance over that of a white one; the middle where there is
/// no light.
fn lambertian(light: &SceneLight<'_>, mean: &[[f32; 3]]) -> Vec<Material> {
    let kd = |t: usize, mean: &[f32; 3]| {
        let local = light.reaching(TriangleId::at(t)).light;
        let white = local.sun * local.direction.z.max(0.0) + local.sky;
        std::array::from_fn(|c| if white[c] > 1e-3 { (mean[c] / white[c]).clamp(0.0, 1.0) } else { 0.5 })
    };
    mean.par_iter().enumerate().map(|(t, mean)| Material { kd: kd(t, mean), ks: [0.0; 3], r: 0.5 }).collect()
}
