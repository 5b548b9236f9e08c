//! A small town with a known truth: ground, streets, houses, flats, halls, trees, every triangle with its material; a
//! sun that casts shadows and a sky; a drone's flight over it.
//!
//! ```text
//! DIR/mesh.ply                 the mesh; x east-ish, y north-ish, z up, metres
//! DIR/images/frame_000.jpg ..  sRGB, exposed so that a white Lambertian that faces the sun has radiance 1, clipped at 1
//! DIR/sparse/0/*.bin           COLMAP model: one PINHOLE camera, the poses, no points
//! DIR/truth/materials.npy      [F,7] f32, rows in the order of the mesh's faces; NaN where no such material is
//! DIR/truth/light.json         the sun's direction and colour, the sky's radiance; of several suns, which frame has which and when
//! DIR/city.json                configuration and version, written last: a folder without it is unfinished
//! ```
//!
//! The city is made block by block, each block from (seed, column, row) alone: once to count the triangles, once more to
//! write them. The mesh is held only while it is written; photographs are taken of the mapped scene cache. The scene cache
//! and each triangle's share of the sky lie in `DIR/unfinished` until all photographs are taken, so that an interrupted
//! making goes on where it stopped. The same configuration gives the same bytes for any number of threads.

mod block;
mod building;
mod config;
mod finish;
mod flight;
mod folder;
mod greenery;
mod missing;
mod palette;
mod real;
mod sky;
mod street;
mod suns;
mod surface;
mod town;
mod world;
pub(crate) mod write;

pub(crate) use config::CityConfig;
pub(crate) use folder::{is_finished, space};
pub(crate) use world::World;
pub(crate) use write::generate_if_needed;

use rayon::prelude::*;

use crate::base::convert::{Cut, to_u32};
use crate::base::{Error, Result};
use crate::scene::Mesh;
use crate::scene::frame::Frame;
use crate::scene::survey::{Polygons, Survey};
use real::given;
use surface::Surface;
use town::{Density, Town, Use};

/// The mesh of a city that need not have been made yet.
///
/// # Errors
/// A value of the configuration is out of range.
pub(crate) fn mesh(config: &CityConfig) -> Result<Mesh> {
    fill(config, Version::Given, survey(config, Version::Given)?, &mut |_| Ok(()))
}

/// The town that is photographed, or what is handed out of it: in the plain world, the same.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Version {
    Town,
    Given,
}

/// Makes the blocks once to count vertices and triangles.
fn survey(config: &CityConfig, version: Version) -> Result<Survey> {
    config.check()?;
    let mut survey = Survey::default();
    each_block(config, version, &mut |block| {
        tell(block, 0, &mut survey);
        Ok(())
    })?;
    Ok(survey)
}

/// Makes the blocks once more to fill the mesh that was surveyed, and hands them on in the order of the mesh's triangles.
/// Besides the mesh, only a few blocks are held.
fn fill(
    config: &CityConfig,
    version: Version,
    survey: Survey,
    blocks: &mut dyn FnMut(&Surface) -> Result<()>,
) -> Result<Mesh> {
    let no_mesh = |why| Error::invalid(format!("city: {why}"));
    let mut filling = survey.filling().map_err(no_mesh)?;
    let mut first = 0;
    each_block(config, version, &mut |block| {
        tell(block, first, &mut filling);
        first += to_u32(block.vertices.len());
        blocks(block)
    })?;
    filling.finish().map_err(no_mesh)
}

/// Blocks made, and held, at a time.
const AT_ONCE: usize = 32;

/// Makes all blocks and hands them on in order.
fn each_block(config: &CityConfig, version: Version, take: &mut dyn FnMut(&Surface) -> Result<()>) -> Result<()> {
    let (town, cell) = lay_out(config);
    let made = |block: Surface| match (config.world, version) {
        (World::Plain, _) => block,
        (World::Real, Version::Town) => given::town(&block),
        (World::Real, Version::Given) => given::given(&block, cell),
    };
    town.blocks().chunks(AT_ONCE).try_for_each(|some| {
        let made: Vec<Surface> = some.par_iter().map(|&at| made(block::build(&town, at, cell, config.world))).collect();
        made.iter().try_for_each(&mut *take)
    })
}

/// Adds a block's vertices and triangles; `first` vertices come before the block's.
fn tell(block: &Surface, first: u32, to: &mut impl Polygons) {
    block.vertices.iter().for_each(|&at| to.vertex(at));
    block.triangles.iter().for_each(|corners| to.polygon(&corners.map(|i| i + first)));
}

/// The frames of the flight, sorted by name.
pub(crate) fn frames(config: &CityConfig) -> Vec<Frame> {
    flight::frames(config, &lay_out(config).0, 1)
}

/// Edge length of the cells that a town's size is chosen for, metres.
const CELL: f64 = 1.8;

/// The town, and the edge length of its cells in metres, with about as many triangles as the configuration asks for.
fn lay_out(config: &CityConfig) -> (Town, f64) {
    let wanted = f64::from(config.triangles);
    let town = |side: i32| Town { seed: config.seed, side };
    let side = i32::cut((wanted / Use::Houses.triangles().in_cells(CELL)).sqrt());
    let miss = |side: i32| (town(side).triangles().in_cells(CELL) / wanted).ln().abs();
    let side = (side - 2..=side + 1).map(|s| s.max(1)).min_by(|a, b| miss(*a).total_cmp(&miss(*b))).unwrap_or(1);
    let Density { fixed, areal } = town(side).triangles();
    // Where the fixed number alone is too large, coarse cells come as close as they can.
    (town(side), (areal / (wanted - fixed).max(1.0)).sqrt().clamp(0.5, 6.0))
}

#[cfg(test)]
mod tests;
