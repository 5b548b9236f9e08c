//! Looks at a sample of triangles in every frame.

use glam::Vec2;

use super::pixels::Trial;
use crate::base::Result;
use crate::base::convert::{to_f32, to_u32};
use crate::base::ids::{FrameId, TriangleId};
use crate::flow::{Map, Outlet, Skipped};
use crate::light::Sighting;
use crate::scene::Mesh;
use crate::scene::frame::{Frame, LinearImage};
use crate::scene::view::View;
use crate::scene::vignetting::radius2;
use crate::stages::decode::{Contents, Decoded};
use crate::trace::Bvh;

/// What one frame saw of the sample, or why it is skipped.
pub(crate) struct Looked {
    /// The frame.
    pub frame: FrameId,
    /// What was read of the frame's files.
    pub contents: Contents,
    /// A row for each triangle that was seen.
    pub rows: Result<Vec<Sighting>, Skipped>,
}

/// Looks at a sample of triangles in a frame.
pub(crate) struct Look<'a> {
    /// All frames, sorted by name.
    pub frames: &'a [Frame],
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The mesh's hierarchy.
    pub bvh: &'a Bvh,
    /// The triangles that are looked at.
    pub sample: &'a [TriangleId],
    /// How much smaller images are, each way, than their cameras.
    pub downscale: u32,
}

/// The fewest pixels that make a row.
const LEAST: u32 = 2;

impl Look<'_> {
    fn rows(&self, frame: FrameId, image: &LinearImage, trial: &mut Trial) -> Vec<Sighting> {
        let posed = &self.frames[frame.index()];
        let view = View::new(posed.camera.down_scaled(self.downscale), &posed.pose, self.mesh);
        let mut rows = Vec::new();
        for (at, &t) in self.sample.iter().enumerate() {
            let (mut sum, mut place) = ([0.0_f64; 3], Vec2::ZERO);
            let (pixels, clipped, mean) = Default::default();
            let mut row = Sighting { frame: frame.0, sample: to_u32(at), pixels, clipped, mean, radius2: 0.0 };
            for pixel in trial.pixels(&view, self.mesh, self.bvh, t) {
                let index = pixel.y as usize * image.width as usize + pixel.x as usize;
                let Some(seen) = image.pixel(index) else { continue };
                row.pixels += 1;
                row.clipped += u32::from(seen.clipped);
                sum.iter_mut().zip(seen.rgb).for_each(|(sum, value)| *sum += f64::from(value));
                place += pixel.as_vec2() + 0.5;
            }
            if row.pixels < LEAST {
                continue;
            }
            row.mean = sum.map(|sum| to_f32(sum / f64::from(row.pixels)));
            row.radius2 = radius2(place / row.pixels as f32, view.size());
            rows.push(row);
        }
        rows
    }
}

impl Map for Look<'_> {
    type In = Decoded;
    type Out = Looked;
    type Scratch = Trial;

    fn scratch(&self) -> Result<Trial> {
        Ok(Trial::default())
    }

    fn apply(&self, trial: &mut Trial, decoded: Decoded, out: &mut Outlet<'_, Looked>) -> Result<()> {
        let Decoded { frame, contents, image } = decoded;
        let rows = image.map(|(image, _memory)| self.rows(frame, &image, trial));
        out.send(Looked { frame, contents, rows })
    }
}
