//! A city's files, in the order of their writing.

use std::fs;
use std::path::Path;

use rayon::prelude::*;
use serde_json::json;

use super::folder::{self, Found, Summary};
use super::{City, CityConfig, build, flight, lighting, plan};
use crate::base::{Error, Result};
use crate::codec::colmap::{self, Encoding};
use crate::codec::{image, npy, ply};
use crate::disk::write_atomic;
use crate::render::{Lighting, relight, sky_visibility};
use crate::scene::Material;
use crate::trace::Bvh;

/// Rays a triangle that find its share of the sky.
const SKY_RAYS: u32 = 64;

/// Makes a city in a folder, unless it is there already: finished, and from the same configuration. `stop` is asked
/// between photographs; those that are there are kept the next time.
///
/// # Errors
/// A configuration out of range; a folder that holds something that is not a city; a file that cannot be written;
/// `Error::Interrupted` where `stop` says so.
pub fn generate_if_needed(folder: &Path, config: &CityConfig, stop: &dyn Fn() -> bool) -> Result<Summary> {
    config.check()?;
    match folder::look(folder, config)? {
        Found::Finished(summary) => Ok(summary),
        Found::Room => make(folder, config, stop),
    }
}

/// Makes a city in a folder, over the one that it may hold.
///
/// # Errors
/// As for [`generate_if_needed`].
pub fn generate(folder: &Path, config: &CityConfig, stop: &dyn Fn() -> bool) -> Result<Summary> {
    config.check()?;
    folder::look(folder, config)?;
    make(folder, config, stop)
}

fn make(dir: &Path, config: &CityConfig, stop: &dyn Fn() -> bool) -> Result<Summary> {
    let city = build(config)?;
    let goes_on = folder::owned(dir, config);
    if !goes_on {
        folder::begin(dir)?;
    }
    for sub in ["images", "sparse/0", "truth"] {
        let sub = dir.join(sub);
        fs::create_dir_all(&sub).map_err(Error::io("create", &sub))?;
    }
    if !goes_on {
        folder::sweep(&dir.join("images"), "frame_", |_| false)?;
        folder::own(dir, config)?;
    }
    let path = dir.join("mesh.ply");
    write_atomic(&path, |mut out| ply::write_mesh(&mut out, &city.mesh, &[]).map_err(Error::io("write", &path)))?;
    let bvh = Bvh::build(&city.mesh);
    let mut light = lighting(config);
    write_truth(&dir.join("truth"), &city, &light)?;
    light.visibility = sky_visibility(&city.mesh, &bvh, light.up, SKY_RAYS);
    let frames = super::frames(config);
    write_images(&dir.join("images"), config, &city, &bvh, &light, stop)?;
    colmap::write_model(&dir.join("sparse/0"), &frames, Encoding::Binary)?;
    let summary = Summary { triangles: city.mesh.len() as u64, frames: frames.len() as u64, reused: false };
    folder::sync(&dir.join("sparse/0"))?;
    folder::finish(dir, config, summary)?;
    Ok(summary)
}

/// Renders, encodes and writes the photographs that are not there yet.
fn write_images(
    dir: &Path,
    config: &CityConfig,
    city: &City,
    bvh: &Bvh,
    light: &Lighting,
    stop: &dyn Fn() -> bool,
) -> Result<()> {
    let n = config.supersampling;
    let frames = flight::frames(config, &plan(config).0, n);
    folder::sweep(dir, "frame_", |name| frames.iter().any(|f| f.name == name))?;
    for frame in frames.iter().filter(|frame| !dir.join(&frame.name).exists()) {
        if stop() {
            return Err(Error::Interrupted);
        }
        let mut picture = relight(&city.mesh, bvh, &city.materials, frame, light)?;
        if n > 1 {
            picture = picture.shrink(n);
        }
        let pixels: Vec<[u8; 3]> = picture.rgb.par_iter().map(|p| p.map(image::to_srgb8)).collect();
        image::write_jpeg(&dir.join(&frame.name), &pixels, config.width, config.height, config.jpeg_quality)?;
    }
    Ok(())
}

/// The materials and the light.
fn write_truth(dir: &Path, city: &City, light: &Lighting) -> Result<()> {
    let path = dir.join("materials.npy");
    let values: Vec<f32> = city.materials.iter().flat_map(|m| m.to_array()).collect();
    write_atomic(&path, |out| {
        npy::write_f32(out, &[city.materials.len(), Material::LEN], &values).map_err(Error::io("write", &path))?;
        Ok(())
    })?;
    let path = dir.join("light.json");
    let text = json!({
        "sun": { "direction": light.sun.direction.to_array(), "color": light.sun.color.to_array() },
        "sky": light.sky.to_array(),
    });
    write_atomic(&path, |out| writeln!(out, "{text:#}").map_err(Error::io("write", &path)))
}
