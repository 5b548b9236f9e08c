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
use crate::scene::view::View;
use crate::shard::{Accumulator, FrameRows};
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

/// What one frame saw of the mesh, or why it is skipped.
pub struct Seen {
    /// Which frame.
    pub frame: FrameId,
    /// What it saw.
    pub rows: Result<FrameRows, Skipped>,
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
}

/// What a worker keeps from frame to frame.
#[derive(Default)]
pub struct Scratch {
    rays: TileRays,
    rows: Accumulator,
}

impl Cast<'_> {
    fn rows(&self, view: &View, image: &LinearImage, scratch: &mut Scratch) -> (FrameRows, u64) {
        let Scratch { rays, rows } = scratch;
        let mut observations = 0;
        // Neighbouring pixels mostly see one triangle: its axes are worked out once for a run of them.
        let mut last: Option<(TriangleId, LobeFrame)> = None;
        for tile in view.tiles(self.tile) {
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
            rows.end_tile();
        }
        (rows.finish(), observations)
    }
}

impl Map for Cast<'_> {
    type In = Decoded;
    type Out = Seen;
    type Scratch = Scratch;

    fn scratch(&self) -> Result<Scratch> {
        Ok(Scratch::default())
    }

    fn apply(&self, scratch: &mut Scratch, decoded: Decoded, out: &mut Outlet<'_, Seen>) -> Result<()> {
        let Decoded { frame, image } = decoded;
        let posed = &self.frames[frame as usize];
        let (mut rays, mut observations) = (0, 0);
        let rows = image.map(|image| {
            let view = View::new(posed.camera.down_scaled(self.downscale), &posed.pose, self.mesh);
            let (rows, seen) = self.rows(&view, &image, scratch);
            (rays, observations) = (image.len() as u64, seen);
            out.count_bytes(rows.bytes());
            rows
        });
        out.send(Seen { frame, rows, rays, observations })
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
