//! Which frames can be read under the limit. A frame that cannot does not end the night: it is skipped, and taken once there is
//! memory for it.

use rayon::prelude::*;

use super::share::{left_for_a_frame, sunlit};
use crate::base::ids::FrameId;
use crate::codec::images::Need;
use crate::phases::scene::LoadedScene;
use crate::pipeline::Pipeline;
use crate::scene::frame::Frame;

/// The bytes that reading each frame takes, and those that are left for one.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Readable {
    /// Bytes that are left for a frame where it is the only one under way.
    pub left: u64,
    /// Bytes that reading takes, frame by frame; `None` where the file's header does not say. Such a frame is skipped for
    /// what is wrong with it when its turn comes.
    pub needs: Vec<Option<u64>>,
}

impl Readable {
    /// Looks at the headers of all images, for a process that holds `process` bytes before it reads a scene.
    pub fn of(pipeline: &Pipeline, scene: &LoadedScene, process: u64) -> Readable {
        let decode = scene.decode(pipeline);
        // Files that have not been made yet will be JPEGs.
        let made = pipeline.is_made();
        let need = |frame: &Frame| match decode.need(frame) {
            Ok(need) => Some(need.peak),
            Err(_) if made => None,
            Err(_) => Some(Need::usual(pixels(pipeline, frame)).peak),
        };
        let held = process + sunlit(pipeline, scene.mesh.len() as u64);
        let left = left_for_a_frame(pipeline.cast.tile, pipeline.run.memory.0.saturating_sub(held));
        Readable { left, needs: scene.frames.par_iter().map(need).collect() }
    }

    /// The bytes that reading a frame takes.
    pub fn need(&self, frame: FrameId) -> Option<u64> {
        self.needs.get(frame.index()).copied().flatten()
    }

    /// Whether a frame is too large to be read.
    pub fn is_too_large(&self, frame: FrameId) -> bool {
        self.need(frame).is_some_and(|need| need > self.left)
    }

    /// How many frames are too large, and what the largest of them takes.
    pub fn too_large(&self) -> (u64, u64) {
        let large = self.needs.iter().flatten().filter(|need| **need > self.left);
        large.fold((0, 0), |(count, most), &need| (count + 1, most.max(need)))
    }

    /// What the largest frame takes that is not too large; if all are, what the smallest does.
    pub fn largest(&self) -> u64 {
        let known = || self.needs.iter().flatten().copied();
        known().filter(|need| *need <= self.left).max().or_else(|| known().min()).unwrap_or(0)
    }
}

/// Pixels of a frame's image.
pub(crate) fn pixels(pipeline: &Pipeline, frame: &Frame) -> u64 {
    let by = pipeline.decode.downscale.max(1);
    u64::from(frame.camera.width / by) * u64::from(frame.camera.height / by)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_too_large_does_not_count() {
        let fit = |left| Readable { left, needs: vec![Some(30), None, Some(10), Some(20)] };
        assert_eq!((fit(30).largest(), fit(30).too_large()), (30, (0, 0)));
        assert_eq!((fit(29).largest(), fit(29).too_large()), (20, (1, 30)));
        assert_eq!((fit(9).largest(), fit(9).too_large()), (10, (3, 30)), "none fits");
        let large: Vec<FrameId> = (0..5).map(FrameId).filter(|&id| fit(15).is_too_large(id)).collect();
        assert_eq!(large, [FrameId(0), FrameId(3)]);
        assert_eq!(Readable::default().largest(), 0);
    }
}
