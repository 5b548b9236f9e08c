//! Writes a city's files, in this order: light, mesh and materials, scene cache, sky, photographs, poses, `city.json`.

use std::path::Path;
use std::sync::Arc;

use rayon::prelude::*;
use serde_json::{Value, json};

use super::folder::{self, Found, Summary};
use super::missing::Missing;
use super::real::photographs;
use super::real::shade::COLUMNS;
use super::surface::Surface;
use super::{CityConfig, Version, World, fill, flight, lay_out, sky, suns, survey};
use crate::base::{Array, Error, Result, memory};
use crate::cache::{self, Cached};
use crate::codec::images;
use crate::codec::meshes::ply;
use crate::codec::poses::colmap::{self, Encoding};
use crate::codec::tables::npy::{self, NpyWriter};
use crate::disk::{DirStore, Store, write_atomic};
use crate::render::{Lighting, relight};
use crate::scene::frame::Frame;
use crate::scene::{Material, Mesh};

/// The folder of the files that photographs are taken with; it exists while the city is being made.
const UNFINISHED: &str = "unfinished";
/// The scene cache.
const CACHE: &str = "unfinished/scene.cache";
/// The materials and substances of a town in the real world.
const TOWN: &str = "unfinished/town.npy";
/// How the names of the files of the sky begin.
const SKY: &str = "unfinished/sky";

/// Whether a file of the folder of an unfinished city is the city's own.
fn is_unfinished(name: &str) -> bool {
    ["scene.cache", "town.npy", "sky"].contains(&name)
        || name.strip_prefix("sky.").is_some_and(|at| at.parse::<usize>().is_ok())
}
/// The mesh.
const MESH: &str = "mesh.ply";
/// The materials of the mesh.
const MATERIALS: &str = "truth/materials.npy";

/// Makes a city in a folder, unless the folder holds it, finished and from the same configuration. `stop` is asked between
/// photographs and within the work before them; the next making goes on from there. `taken` is told how many photographs there are.
///
/// # Errors
/// A value of the configuration is out of range; the folder holds files that are not a city's; the disk is too small; a
/// file cannot be written; `Error::Interrupted` where `stop` says so.
pub(crate) fn generate_if_needed(
    folder: &Path,
    config: &CityConfig,
    stop: &dyn Fn() -> bool,
    taken: &dyn Fn(usize),
) -> Result<Summary> {
    config.check()?;
    match folder::look(folder, config)? {
        Found::Finished(summary) => Ok(summary),
        Found::Free => make(folder, config, stop, taken),
    }
}

/// Makes a city in a folder, over any city that the folder holds.
///
/// # Errors
/// The errors of [`generate_if_needed`].
#[cfg(test)]
pub(crate) fn generate(folder: &Path, config: &CityConfig, stop: &dyn Fn() -> bool) -> Result<Summary> {
    config.check()?;
    folder::look(folder, config)?;
    make(folder, config, stop, &|_| {})
}

/// Makes a city in a folder that may hold one.
fn make(dir: &Path, config: &CityConfig, stop: &dyn Fn() -> bool, taken: &dyn Fn(usize)) -> Result<Summary> {
    if let Some(space) = folder::space(dir, config)? {
        space.enough("--out, or into in [synth]")?;
    }
    let store = DirStore::new(dir);
    let goes_on = folder::owned(dir, config);
    if !goes_on {
        folder::begin(dir)?;
    }
    for sub in ["images", "sparse/0", "truth"] {
        folder::make_below(dir, sub)?;
    }
    if !goes_on {
        folder::sweep(&dir.join("images"), |_| false)?;
        folder::remove(&dir.join(MESH))?;
        folder::remove(&dir.join(MATERIALS))?;
        folder::remove_unfinished(&store, UNFINISHED, is_unfinished)?;
        folder::own(dir, config)?;
    }
    store.sweep()?;
    let lights = suns::lights(config);
    let frames = flight::frames(config, &lay_out(config).0, config.supersampling);
    write_light(&dir.join("truth/light.json"), config, &lights, &frames)?;
    folder::sweep(&dir.join("images"), |name| frames.iter().any(|f| f.name == name))?;
    let missing: Vec<(usize, &Frame)> =
        frames.iter().enumerate().filter(|(_, f)| !dir.join("images").join(&f.name).exists()).collect();
    let missing = Missing::new(missing, frames.len(), taken, stop);
    let written = dir.join(MESH).exists() && dir.join(MATERIALS).exists();
    let mut cached = if missing.frames.is_empty() { None } else { cache::open(&store, CACHE).ok() };
    if !written || (cached.is_none() && !missing.frames.is_empty()) {
        write_surface(dir, &store, config, stop)?;
        cached = Some(cache::open(&store, CACHE)?);
    }
    let materials = npy::view(Arc::new(store.open(MATERIALS)?), &store.path(MATERIALS))?;
    if let Some(cached) = cached.filter(|_| !missing.frames.is_empty()) {
        let images = dir.join("images");
        match config.world {
            World::Plain => {
                let shares = sky::shares(&store, SKY, &cached.mesh, &cached.bvh, glam::Vec3::Z, stop)?;
                let over = |light| Lighting { visibility: shares.clone(), ..light };
                let lights: Vec<Lighting> = lights.into_iter().map(over).collect();
                take(&images, config, &missing, &cached, &materials, &lights)?;
            }
            World::Real => {
                let rows = npy::view::<COLUMNS>(Arc::new(store.open(TOWN)?), &store.path(TOWN))?;
                photographs::take(&images, config, &missing, &cached, &rows, stop)?;
            }
        }
    }
    let frames = super::frames(config);
    colmap::write_model(&dir.join("sparse/0"), &frames, Encoding::Binary)?;
    let summary = Summary { triangles: materials.len() as u64, frames: frames.len() as u64, reused: false };
    folder::sync(&dir.join("sparse/0"))?;
    folder::remove_unfinished(&store, UNFINISHED, is_unfinished)?;
    folder::finish(dir, config, summary)?;
    Ok(summary)
}

/// Makes the mesh and writes mesh, materials and scene cache. The mesh is not held afterwards.
fn write_surface(dir: &Path, store: &DirStore, config: &CityConfig, stop: &dyn Fn() -> bool) -> Result<()> {
    let material = |block: &Surface, t: usize| block.materials[t].to_array();
    let mut mesh = write_rows(&dir.join(MATERIALS), config, Version::Given, &material)?;
    let path = dir.join(MESH);
    write_atomic(&path, |mut out| ply::write_mesh(&mut out, &mesh, &[]).map_err(Error::io("write", &path)))?;
    if config.world == World::Real {
        drop(mesh);
        folder::make_below(dir, UNFINISHED)?;
        mesh = write_rows(&store.path(TOWN), config, Version::Town, &|block, t| {
            let mut row = [0.0; COLUMNS];
            row[..Material::LEN].copy_from_slice(&block.materials[t].to_array());
            row[Material::LEN] = block.substances[t].number().into();
            row
        })?;
    }
    folder::remove(&store.path(CACHE))?;
    cache::write(&mesh, store, CACHE, stop)?;
    drop(mesh);
    memory::trim();
    Ok(())
}

/// Makes a mesh and writes a row for each of its triangles.
fn write_rows<const N: usize>(
    path: &Path,
    config: &CityConfig,
    version: Version,
    row: &dyn Fn(&Surface, usize) -> [f32; N],
) -> Result<Mesh> {
    let survey = survey(config, version)?;
    let failed = |why| Error::io("write", path)(why);
    let mut mesh = None;
    write_atomic(path, |out| {
        let mut rows = NpyWriter::new(out, &[survey.triangles(), N]).map_err(failed)?;
        mesh = Some(fill(config, version, survey, &mut |block| {
            (0..block.triangles.len()).try_for_each(|t| rows.write(&row(block, t))).map_err(failed)
        })?);
        rows.finish().map(drop).map_err(failed)
    })?;
    mesh.ok_or_else(|| Error::invalid("no mesh was made"))
}

/// Renders, encodes and writes photographs into a folder.
fn take(
    dir: &Path,
    config: &CityConfig,
    missing: &Missing<'_>,
    scene: &Cached,
    materials: &Array<[f32; Material::LEN]>,
    lights: &[Lighting],
) -> Result<()> {
    let n = config.supersampling;
    missing.frames.iter().try_for_each(|&(k, frame)| {
        missing.take(|| {
            let light = &lights[suns::of_frame(config, k)];
            let mut picture = relight(&scene.mesh, &scene.bvh, bytemuck::cast_slice(materials), frame, light)?;
            if n > 1 {
                picture = picture.shrink(n);
            }
            let pixels: Vec<[u8; 3]> = picture.rgb.par_iter().map(|p| p.map(images::to_srgb8)).collect();
            let (path, size) = (dir.join(&frame.name), [config.width, config.height]);
            images::write_jpeg_taken(&path, &pixels, size, config.jpeg_quality, suns::taken(config, k))
        })
    })
}

/// Writes the file of the light: the sun, or the suns and the one of each frame, and the sky.
fn write_light(path: &Path, config: &CityConfig, lights: &[Lighting], frames: &[Frame]) -> Result<()> {
    let sun =
        |light: &Lighting| json!({ "direction": light.sun.direction.to_array(), "color": light.sun.color.to_array() });
    let mut text = json!({ "sky": config.sky });
    if let [light] = lights {
        text["sun"] = sun(light);
    } else {
        let of_frame = |(k, frame): (usize, &Frame)| {
            let time = suns::taken(config, k).map(|time| time.to_string());
            (frame.name.clone(), json!({ "sun": suns::of_frame(config, k), "time": time }))
        };
        text["suns"] = lights.iter().map(sun).collect();
        text["frames"] = Value::Object(frames.iter().enumerate().map(of_frame).collect());
    }
    write_atomic(path, |out| writeln!(out, "{text:#}").map_err(Error::io("write", path)))
}
