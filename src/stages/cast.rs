//! Cast: a linear image becomes observations, one ray a pixel, tile by tile.

use serde::Serialize;

use super::Fault;
use super::decode::Decoded;
use crate::base::Result;
use crate::base::ids::{FrameId, TriangleId};
use crate::flow::{Map, Outlet, Skipped};
use crate::scene::Mesh;
use crate::scene::frame::{Frame, LinearImage};
use crate::scene::reflectance::{BinSum, LobeFrame, bin_of};
use crate::scene::view::{Tile, View};
use crate::shard::{Accumulator, FrameRows, Record};
use crate::trace::{Bvh, TileRays};

/// Section `[cast]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// Edge length of a tile, pixels: a power of two, 8 to 256. Rays of a tile are traced together and its observations
    /// summed together, so larger tiles write less and hold more. The result does not depend on it.
    pub tile: u32,
}

impl Default for Config {
    fn default() -> Self {
        Config { tile: 32 }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        if (8..=256).contains(&self.tile) && self.tile.is_power_of_two() {
            return Vec::new();
        }
        vec![Fault::new("tile", "must be a power of two, 8 to 256", self.tile)]
    }
}

/// What one frame saw of the mesh, or a part of it, or why it is skipped.
pub struct Seen {
    /// Which frame.
    pub frame: FrameId,
    /// What it saw.
    pub rows: Result<FrameRows, Skipped>,
    /// Whether further parts of the frame follow. The last one tells what was cast.
    pub more: bool,
    /// Rays cast.
    pub rays: u64,
    /// Pixels that saw a triangle from the front and count.
    pub observations: u64,
}

/// Casts every pixel of a frame onto the mesh.
pub struct Cast<'a> {
    /// All frames, sorted by name.
    pub frames: &'a [Frame],
    /// The mesh.
    pub mesh: &'a Mesh,
    /// Its hierarchy.
    pub bvh: &'a Bvh,
    /// Edge length of a tile, pixels.
    pub tile: u32,
    /// By how much images are smaller than their cameras say.
    pub downscale: u32,
    /// Bytes of a frame's rows from which on they are handed on in parts. The result does not depend on it.
    pub part: u64,
}

/// What a worker keeps from frame to frame.
pub struct Scratch {
    rays: TileRays,
    rows: Accumulator,
}

/// The most parts of frames that are alive at once besides those that the next stage has taken: one that grows in each
/// worker's hands, one beside it that waits for its turn, one of each further frame that is done ahead of its turn, and
/// those in the queue and in the next stage's hands.
pub fn parts_alive(workers: usize, queue: usize) -> usize {
    3 * workers + queue + 1
}

/// Bytes that a worker holds for a tile of this edge length: pixels, rays and hits, and its observations.
pub fn tile_bytes(tile: u32) -> u64 {
    u64::from(tile) * u64::from(tile) * (TileRays::BYTES_PER_PIXEL + 2 * Record::BYTES)
}

impl Cast<'_> {
    /// Casts the pixels of tiles; gives `part` the rows whenever they have become too many to be held. Gives the rest of
    /// the rows and the number of observations.
    pub fn rows(
        &self,
        view: &View,
        tiles: impl Iterator<Item = Tile>,
        image: &LinearImage,
        scratch: &mut Scratch,
        mut part: impl FnMut(FrameRows) -> Result<()>,
    ) -> Result<(FrameRows, u64)> {
        let Scratch { rays, rows } = scratch;
        let mut observations = 0;
        // Neighbouring pixels mostly see one triangle: its axes are worked out once for a run of them.
        let mut last: Option<(TriangleId, LobeFrame)> = None;
        for tile in tiles {
            for (at, direction, hit) in rays.cast(view, self.bvh, tile).filter(|(.., hit)| hit.is_some()) {
                let Some(pixel) = image.pixel(tile.position(at, image.width)) else { continue };
                if last.is_none_or(|(t, _)| t != hit.triangle) {
                    last = self.mesh.lobe_frame(hit.triangle).map(|axes| (hit.triangle, axes));
                }
                let Some((triangle, axes)) = last else { continue };
                let towards = axes.to_local(-direction);
                if towards.z > 0.0 {
                    rows.observe(triangle, bin_of(towards), BinSum::one(pixel.rgb, pixel.clipped));
                    observations += 1;
                }
            }
            rows.end_tile().map_or(Ok(()), &mut part)?;
        }
        Ok((rows.finish(), observations))
    }
}

impl Map for Cast<'_> {
    type In = Decoded;
    type Out = Seen;
    type Scratch = Scratch;

    fn scratch(&self) -> Result<Scratch> {
        Ok(Scratch { rays: TileRays::default(), rows: Accumulator::new(self.part) })
    }

    fn apply(&self, scratch: &mut Scratch, decoded: Decoded, out: &mut Outlet<'_, Seen>) -> Result<()> {
        let Decoded { frame, image } = decoded;
        let last = Seen { frame, rows: Ok(FrameRows::default()), more: false, rays: 0, observations: 0 };
        let (image, memory) = match image {
            Ok(image) => image,
            Err(skipped) => return out.send(Seen { rows: Err(skipped), ..last }),
        };
        let posed = &self.frames[frame as usize];
        let view = View::new(posed.camera.down_scaled(self.downscale), &posed.pose, self.mesh);
        let (rows, observations) = self.rows(&view, view.tiles(self.tile), &image, scratch, |part| {
            out.count_bytes(part.bytes());
            out.send(Seen { frame, rows: Ok(part), more: true, rays: 0, observations: 0 })
        })?;
        let rays = image.len() as u64;
        // What waits for its turn is the rows alone.
        drop((image, memory));
        out.count_bytes(rows.bytes());
        out.send(Seen { rows: Ok(rows), rays, observations, ..last })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn tiles_are_powers_of_two() {
        for (tile, faults) in [(8, 0), (32, 0), (256, 0), (0, 1), (4, 1), (33, 1), (512, 1), (u32::MAX, 1)] {
            assert_eq!(Config { tile }.check().len(), faults, "{tile}");
        }
    }
}
