//! Casts the pixels of a view's tile.

use glam::{UVec2, Vec3};

use super::bvh::Bvh;
use super::ray::Hit;
use super::tile;
use crate::scene::view::{Tile, View};

/// The ray of one pixel and its hit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PixelHit {
    /// The pixel's column and row in the tile.
    pub pixel: UVec2,
    /// The ray's unit direction.
    pub direction: Vec3,
    /// The nearest triangle along the ray; [`Hit::MISS`] if there is none.
    pub hit: Hit,
}

/// The rays of one tile and their hits; reused from tile to tile.
#[derive(Debug, Default)]
pub(crate) struct TileRays {
    size: UVec2,
    /// Pixels of the tile, in the order in which they are cast.
    pixels: Vec<UVec2>,
    directions: Vec<Vec3>,
    hits: Vec<Hit>,
}

impl TileRays {
    /// Bytes of memory held per pixel of the largest tile.
    pub(crate) const BYTES_PER_PIXEL: u64 = (size_of::<UVec2>() + size_of::<Vec3>() + size_of::<Hit>()) as u64;

    /// Casts the pixels of a tile and gives the ray and the hit of each.
    pub(crate) fn cast(&mut self, view: &View, bvh: &Bvh, tile: Tile) -> impl Iterator<Item = PixelHit> + Clone {
        let size = UVec2::new(tile.width, tile.height);
        if self.size != size {
            self.size = size;
            self.pixels = tile::order(tile.width, tile.height);
        }
        view.directions(tile, &self.pixels, &mut self.directions);
        self.hits.clear();
        self.hits.resize(self.directions.len(), Hit::MISS);
        tile::cast(bvh, view.centre(), &self.directions, &mut self.hits);
        let cast = self.pixels.iter().zip(&self.directions).zip(&self.hits);
        cast.map(|((&pixel, &direction), &hit)| PixelHit { pixel, direction, hit })
    }
}
