//! The pixels of a view's tile, cast.

use glam::Vec3;

use super::{Bvh, Hit, tile};
use crate::scene::view::{Tile, View};

/// The rays of one tile and what they hit; reused from tile to tile.
#[derive(Debug, Default)]
pub struct TileRays {
    size: (u32, u32),
    /// Pixels of the tile, (column, row), in the order in which they are cast.
    pixels: Vec<(u32, u32)>,
    directions: Vec<Vec3>,
    hits: Vec<Hit>,
}

impl TileRays {
    /// Bytes of memory that it holds per pixel of the largest tile.
    pub const BYTES_PER_PIXEL: u64 = (size_of::<(u32, u32)>() + size_of::<Vec3>() + size_of::<Hit>()) as u64;

    /// Casts the pixels of a tile and gives, for each of them, (column, row) in the tile, its unit direction and what it
    /// hit: [`Hit::MISS`] if nothing.
    pub fn cast(&mut self, view: &View, bvh: &Bvh, tile: Tile) -> impl Iterator<Item = ((u32, u32), Vec3, Hit)> {
        if self.size != (tile.width, tile.height) {
            self.size = (tile.width, tile.height);
            self.pixels = tile::order(tile.width, tile.height);
        }
        view.directions(tile, &self.pixels, &mut self.directions);
        self.hits.clear();
        self.hits.resize(self.directions.len(), Hit::MISS);
        tile::cast(bvh, view.centre(), &self.directions, &mut self.hits);
        self.pixels.iter().zip(&self.directions).zip(&self.hits).map(|((&p, &d), &hit)| (p, d, hit))
    }
}
