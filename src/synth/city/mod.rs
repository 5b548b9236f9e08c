//! A small town with a known truth: ground, streets, houses, flats, halls, trees, every triangle with its material; a
//! sun that casts shadows and a sky; a drone's flight over it.
//!
//! ```text
//! DIR/mesh.ply                 the mesh; x east-ish, y north-ish, z up, metres
//! DIR/images/frame_000.jpg ..  sRGB, exposed so that a white Lambertian that faces the sun has radiance 1, clipped at 1
//! DIR/sparse/0/*.bin           COLMAP model: one PINHOLE camera, the poses, no points
//! DIR/truth/materials.npy      [F,7] f32, rows in the order of the mesh's faces
//! DIR/truth/light.json         the sun's direction and colour, the sky's radiance
//! DIR/city.json                configuration and version, written last: what lacks it is unfinished
//! ```
//!
//! The city is made block by block, each from (seed, column, row) alone: once to be counted, once more to be written. The
//! mesh is held while it is written; photographs are taken of what is mapped. What they need besides, the scene cache and
//! each triangle's share of the sky, is in `DIR/unfinished` until all are taken, so that a making that was interrupted goes on
//! where it was. The same configuration gives the same bytes for any number of threads.

mod block;
mod building;
mod config;
mod flight;
mod folder;
mod greenery;
mod palette;
mod sky;
mod street;
mod surface;
mod town;
mod write;

pub use config::CityConfig;
pub use folder::{Summary, is_finished, room};
pub use write::{generate, generate_if_needed};

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::base::{Error, Result};
use crate::render::Lighting;
use crate::scene::frame::Frame;
use crate::scene::light::Sun;
use crate::scene::survey::{Polygons, Survey};
use crate::scene::{Material, Mesh};
use surface::Surface;
use town::{Town, Use};

/// The mesh of a city and the material of each of its triangles.
#[derive(Debug, Clone)]
pub struct City {
    /// The mesh.
    pub mesh: Mesh,
    /// One material a triangle.
    pub materials: Vec<Material>,
}

/// Makes the mesh and its materials.
///
/// # Errors
/// A configuration out of range.
pub fn build(config: &CityConfig) -> Result<City> {
    let survey = survey(config)?;
    let mut materials = Vec::with_capacity(survey.triangles());
    let mesh = fill(config, survey, &mut |some| {
        materials.extend_from_slice(some);
        Ok(())
    })?;
    Ok(City { mesh, materials })
}

/// Makes the blocks once to find out how much they come to.
fn survey(config: &CityConfig) -> Result<Survey> {
    config.check()?;
    let mut survey = Survey::default();
    each_block(config, &mut |block| {
        tell(block, 0, &mut survey);
        Ok(())
    })?;
    Ok(survey)
}

/// Makes the blocks again for the mesh, and hands their materials on in the order of its triangles. Besides the mesh, no more
/// than a few blocks are held.
fn fill(config: &CityConfig, survey: Survey, materials: &mut dyn FnMut(&[Material]) -> Result<()>) -> Result<Mesh> {
    let no_mesh = |why| Error::invalid(format!("city: {why}"));
    let mut filling = survey.filling().map_err(no_mesh)?;
    let mut first = 0;
    each_block(config, &mut |block| {
        tell(block, first, &mut filling);
        first += block.vertices.len() as u32;
        materials(&block.materials)
    })?;
    filling.finish().map_err(no_mesh)
}

/// Blocks that are made, and held, at a time.
const AT_ONCE: usize = 32;

/// Makes all blocks and hands them on in their order.
fn each_block(config: &CityConfig, take: &mut dyn FnMut(&Surface) -> Result<()>) -> Result<()> {
    let (town, cell) = plan(config);
    town.blocks().chunks(AT_ONCE).try_for_each(|some| {
        let made: Vec<Surface> = some.par_iter().map(|&at| block::build(&town, at, cell)).collect();
        made.iter().try_for_each(&mut *take)
    })
}

/// Tells of a block before which there are `first` vertices.
fn tell(block: &Surface, first: u32, to: &mut impl Polygons) {
    block.vertices.iter().for_each(|&at| to.vertex(at));
    block.triangles.iter().for_each(|corners| to.triangle(corners.map(|i| i + first)));
}

/// The light that a city stands in, all of the sky seen from everywhere.
pub fn lighting(config: &CityConfig) -> Lighting {
    let (azimuth, elevation) = (config.sun_azimuth_deg.to_radians(), config.sun_elevation_deg.to_radians());
    let direction = DVec3::new(azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin());
    let sun = Sun { direction: direction.as_vec3().normalize(), color: Vec3::ONE };
    Lighting { background: HAZE, ..Lighting::new(sun, Vec3::from(config.sky)) }
}

/// The frames of the flight, in the order of their names.
pub fn frames(config: &CityConfig) -> Vec<Frame> {
    flight::frames(config, &plan(config).0, 1)
}

/// What lies beyond the fields.
const HAZE: Vec3 = Vec3::new(0.45, 0.52, 0.6);

/// Edge length of cells that the size of a town is chosen for, metres.
const CELL: f64 = 1.8;

/// The town, and the cells' edge length, that give about the triangles that are asked for.
fn plan(config: &CityConfig) -> (Town, f64) {
    let wanted = f64::from(config.triangles);
    let town = |side: i32| Town { seed: config.seed, side };
    let count = |(fixed, areal): (f64, f64), cell: f64| fixed + areal / (cell * cell);
    let side = (wanted / count(Use::Houses.triangles(), CELL)).sqrt() as i32;
    let miss = |side: i32| (count(town(side).triangles(), CELL) / wanted).ln().abs();
    let side = (side - 2..=side + 1).map(|s| s.max(1)).min_by(|a, b| miss(*a).total_cmp(&miss(*b))).unwrap_or(1);
    let (fixed, areal) = town(side).triangles();
    // What the fixed part alone exceeds is met as well as coarse cells can.
    (town(side), (areal / (wanted - fixed).max(1.0)).sqrt().clamp(0.5, 6.0))
}

#[cfg(test)]
mod tests;
