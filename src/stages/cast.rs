//! Cast: a linear image becomes observations, one ray a pixel, tile by tile.

use std::ops::AddAssign;

use glam::UVec2;
use serde::{Deserialize, Serialize};

use super::decode::{Contents, Decoded};
use super::sunlit::{Sunlit, TileReach};
use crate::base::Result;
use crate::base::convert::to_u8;
use crate::base::ids::{FrameId, TriangleId};
use crate::config::{Effect, Key, Keys, Section, Settings, Value};
use crate::flow::{Map, Outlet, Skipped};
use crate::scene::Mesh;
use crate::scene::cells::{Reach, cell};
use crate::scene::frame::{Frame, LinearImage};
use crate::scene::reflectance::{BinSum, LobeFrame, bin_of};
use crate::scene::view::{Tile, View};
use crate::scene::vignetting::Vignetting;
use crate::shard::{Accumulator, FrameRecords, Record};
use crate::trace::{Bvh, PixelHit, TileRays};

/// Section `[cast]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// A tile's edge length in pixels: a power of two, 8 to 256. The rays of a tile are traced together and its observations
    /// are summed together, so larger tiles write less and hold more. The result does not depend on it.
    pub tile: u32,
}

impl Section for Config {
    const NAME: &'static str = "cast";
    const ABOUT: &'static str = "How the pixels of a frame are cast onto the mesh.";
    const KEYS: &'static [Key] = &[Key {
        name: "tile",
        doc: "The edge length of a tile of rays in pixels, a power of two, 8 to 256. It changes the speed, never the result.",
        value: Value::Default("32"),
    }];

    fn read(keys: &Keys<'_>) -> Self {
        let tile: u32 = keys.value("tile");
        let good = (8..=256).contains(&tile) && tile.is_power_of_two();
        keys.check("tile", good, "must be a power of two, 8 to 256");
        Config { tile }
    }

    fn settings(&self) -> Settings {
        let Config { tile } = self;
        Settings::of(Self::NAME).with("tile", tile, Effect::Nothing)
    }
}

/// What one frame saw of the mesh, or a piece of it, or why it is skipped.
pub(crate) struct Seen {
    /// The records of what the frame saw.
    pub rows: Result<FrameRecords, Skipped>,
    /// The frame and what was read of it, with the frame's last piece.
    pub last: Option<(FrameId, Contents)>,
    /// The counts of the frame, with its last piece; the others have zeros.
    pub counts: Counts,
}

/// What is counted while frames are cast.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(crate) struct Counts {
    /// Rays cast.
    pub rays: u64,
    /// Pixels that no mask ignores.
    pub unmasked: u64,
    /// Pixels that saw a triangle from the front and count.
    pub observations: u64,
    /// Pixels that saw a triangle from behind.
    pub behind: u64,
    /// Observations that are brighter than [`BRIGHT`].
    pub bright: u64,
}

/// The radiance, linear, that little outdoors exceeds where white in the sun is 1: what is mostly brighter is scaled otherwise.
const BRIGHT: f32 = 10.0;

impl AddAssign for Counts {
    fn add_assign(&mut self, more: Counts) {
        let Counts { rays, unmasked, observations, behind, bright } = more;
        self.rays += rays;
        self.unmasked += unmasked;
        self.observations += observations;
        self.behind += behind;
        self.bright += bright;
    }
}

/// Casts every pixel of a frame onto the mesh.
pub(crate) struct Cast<'a> {
    /// All frames, sorted by name.
    pub frames: &'a [Frame],
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The mesh's hierarchy.
    pub bvh: &'a Bvh,
    /// A tile's edge length in pixels.
    pub tile: u32,
    /// How much smaller images are, each way, than their cameras.
    pub downscale: u32,
    /// A frame's records are handed on whenever they take this many bytes. The result does not depend on it.
    pub piece: u64,
    /// How each frame was taken.
    pub conditions: &'a [Conditions],
    /// The sun of each light, where one is known: what is seen in it is kept apart from what is seen in the shade.
    pub suns: &'a [Option<Sunlit>],
}

/// How a frame was taken.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Conditions {
    /// What its radiance is divided by.
    pub gain: f32,
    /// How much darker it is towards its corners, which is taken out too.
    pub vignetting: Vignetting,
    /// The position of the light that it was taken in.
    pub light: usize,
}

/// A worker's buffers, kept from frame to frame.
pub(crate) struct Scratch {
    rays: TileRays,
    reach: TileReach,
    rows: Accumulator,
}

/// The most pieces of frames that are alive at once before the next stage has taken them. Each worker has one that grows, one
/// that waits for its turn, and one of a frame that was done ahead of its turn; others are in the queue and in the next stage's
/// hands.
pub(crate) fn pieces_alive(workers: usize, queue: usize) -> usize {
    3 * workers + queue + 1
}

/// Bytes that a worker holds for a tile of this edge length: pixels, rays and hits, with those around it, and its
/// observations.
pub(crate) fn tile_bytes(tile: u32) -> u64 {
    let border = (TileRays::BYTES_PER_PIXEL + TileReach::BYTES_PER_PIXEL) * u64::from(tile + 2).pow(2);
    border + u64::from(tile).pow(2) * 2 * Record::BYTES
}

impl Cast<'_> {
    /// Casts the pixels of tiles of a frame that was taken so. Hands records to `piece` whenever they take too much memory; gives
    /// the rest of the records, and counts what was seen.
    pub(crate) fn rows(
        &self,
        view: &View,
        tiles: impl Iterator<Item = Tile>,
        image: &LinearImage,
        Conditions { gain, vignetting, light }: Conditions,
        scratch: &mut Scratch,
        mut piece: impl FnMut(FrameRecords) -> Result<()>,
    ) -> Result<(FrameRecords, Counts)> {
        let Scratch { rays, reach, rows } = scratch;
        let mut counts = Counts::default();
        let sunlit = self.suns.get(light).and_then(Option::as_ref);
        // Neighbouring pixels mostly see one triangle, whose axes are worked out once.
        let mut last: Option<(TriangleId, LobeFrame)> = None;
        for tile in tiles {
            let cast = if sunlit.is_some() { tile.with_border(view.size()) } else { tile };
            let hits = rays.cast(view, self.bvh, cast);
            if let Some(sunlit) = sunlit {
                let size = UVec2::new(cast.width, cast.height);
                reach.look(sunlit, (self.mesh, self.bvh), view.centre(), size, hits.clone());
            }
            let inside = |ray: &PixelHit| tile.holds(ray.pixel + UVec2::new(cast.x, cast.y));
            for PixelHit { pixel: at, direction, hit } in hits.filter(|ray| ray.hit.is_some() && inside(ray)) {
                let Some(pixel) = image.pixel(cast.position(at, image.width)) else { continue };
                if last.is_none_or(|(t, _)| t != hit.triangle) {
                    last = self.mesh.lobe_frame(hit.triangle).map(|axes| (hit.triangle, axes));
                }
                let Some((triangle, axes)) = last else { continue };
                let towards = axes.to_local(-direction);
                if towards.z > 0.0 {
                    let by = gain * vignetting.at_pixel(at + UVec2::new(cast.x, cast.y), view.size());
                    rows.observe(
                        triangle,
                        cell(to_u8(light), sunlit.map_or(Reach::Untold, |_| reach.at(at)), bin_of(towards)),
                        BinSum::one(pixel.rgb.map(|value| value / by), pixel.clipped),
                    );
                    counts.observations += 1;
                    counts.bright += u64::from(pixel.rgb.iter().any(|&value| value > BRIGHT));
                } else {
                    counts.behind += 1;
                }
            }
            rows.end_tile().map_or(Ok(()), &mut piece)?;
        }
        Ok((rows.finish(), counts))
    }
}

impl Map for Cast<'_> {
    type In = Decoded;
    type Out = Seen;
    type Scratch = Scratch;

    fn scratch(&self) -> Result<Scratch> {
        Ok(Scratch { rays: TileRays::default(), reach: TileReach::default(), rows: Accumulator::new(self.piece) })
    }

    fn apply(&self, scratch: &mut Scratch, decoded: Decoded, out: &mut Outlet<'_, Seen>) -> Result<()> {
        let Decoded { frame, contents, image } = decoded;
        let last = Some((frame, contents));
        let (image, memory) = match image {
            Ok(image) => image,
            Err(skipped) => return out.send(Seen { rows: Err(skipped), last, counts: Counts::default() }),
        };
        let posed = &self.frames[frame.index()];
        let view = View::new(posed.camera.down_scaled(self.downscale), &posed.pose, self.mesh);
        let conditions = self.conditions[frame.index()];
        let (rows, mut counts) = self.rows(&view, view.tiles(self.tile), &image, conditions, scratch, |piece| {
            out.count_bytes(piece.bytes());
            out.send(Seen { rows: Ok(piece), last: None, counts: Counts::default() })
        })?;
        (counts.rays, counts.unmasked) = (image.len() as u64, image.unmasked());
        // Only the records wait for their turn.
        drop((image, memory));
        out.count_bytes(rows.bytes());
        out.send(Seen { rows: Ok(rows), last, counts })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::read_text;

    #[test]
    fn tiles_are_powers_of_two() {
        for (tile, problems) in [(8, 0), (32, 0), (256, 0), (0, 1), (4, 1), (33, 1), (512, 1), (u32::MAX, 1)] {
            assert_eq!(read_text::<Config>(&format!("tile = {tile}")).1.len(), problems, "{tile}");
        }
    }
}
