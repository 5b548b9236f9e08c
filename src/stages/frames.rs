//! Frames: hands on the frames to be cast, in order, each with the memory that it takes.
//!
//! A frame's file says in its header how much memory reading takes. The frame is handed on once that much is free, and needs
//! no more later; nor do the stages after it hold anything that depends on it. So every frame comes through whose memory is
//! there while no other frame is under way.

use super::decode::{Content, Contents, Decode, Lent, Unread, is_broken, not_read, skipped};
use super::gather::GroupFrames;
use crate::base::Result;
use crate::base::units::Bytes;
use crate::codec::images::Need;
use crate::flow::{Budget, Outlet, Source};
use crate::scene::frame::Frame;

/// Produces the frames of groups, group after group.
pub(crate) struct Frames<'a> {
    /// The groups to be cast.
    pub groups: &'a [GroupFrames],
    /// The reader of the frames.
    pub decode: Decode<'a>,
    /// The budget that lends the frames their memory.
    pub budget: &'a Budget,
    /// Bytes that all frames under way may hold together.
    pub memory: u64,
}

impl Source for Frames<'_> {
    type Out = Lent;

    fn total(&self) -> Option<u64> {
        Some(self.groups.iter().map(|g| g.frames.len() as u64).sum())
    }

    fn run(self, out: &mut Outlet<'_, Lent>) -> Result<()> {
        for &frame in self.groups.iter().flat_map(|g| &g.frames) {
            let posed = &self.decode.frames[frame.index()];
            let memory = match self.bytes(posed) {
                Ok(bytes) => Ok(self.budget.reserve("frames", bytes)?),
                Err((content, why)) => {
                    let skipped = skipped(posed, &why, &self.decode.replay);
                    Err(Unread { skipped, contents: Contents::without(content) })
                }
            };
            out.send(Lent { frame, memory })?;
        }
        Ok(())
    }
}

impl Frames<'_> {
    /// The bytes that reading a frame takes, or why it is skipped.
    fn bytes(&self, frame: &Frame) -> Result<u64, (Content, String)> {
        let need = match self.decode.patience.with(|| self.decode.need(frame)) {
            Ok(need) => need,
            // What is wrong is found again in the bytes that are read, whose key is remembered.
            Err(why) if is_broken(&why) => {
                Need { peak: self.decode.image_need(frame) + self.decode.bytes(frame) + HEADER, held: 0 }
            }
            Err(why) => return Err((Content::NotRead, not_read(&why))),
        };
        within(need, self.memory, self.budget.total()).map_err(|why| (Content::TooLarge, why))
    }
}

/// The bytes that reading a broken header takes, beside those of the file.
const HEADER: u64 = 1 << 20;

/// The bytes to lend, or why there will never be that many.
fn within(need: Need, memory: u64, limit: u64) -> Result<u64, String> {
    let [needs, has, limit] = [need.peak, memory, limit].map(Bytes);
    let why = || {
        format!(
            "reading it takes {needs} of memory, and [run] memory = \"{limit}\" leaves {has} for it: raise the limit, or \
             make the images smaller and set [decode] downscale"
        )
    };
    (need.peak <= memory).then_some(need.peak).ok_or_else(why)
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::{DVec2, DVec3};

    use super::*;
    use crate::codec::images::{self, Curve};
    use crate::flow::StopSignal;
    use crate::scene::camera::{Camera, Lens};
    use crate::scene::pose::Pose;

    #[test]
    fn a_broken_mask_is_told_of_and_not_the_memory_that_its_image_takes() {
        let dir = tempfile::tempdir().unwrap();
        image::RgbImage::new(800, 600).save(dir.path().join("a.png")).unwrap();
        image::GrayImage::new(400, 300).save(dir.path().join("a_mask.png")).unwrap();
        let lens = Lens::pinhole(DVec2::splat(500.0), DVec2::new(400.0, 300.0));
        let camera = Camera { width: 800, height: 600, lens }.into();
        let frames = [Frame { name: "a.png".to_owned(), camera, pose: Pose::look_at(DVec3::Z, DVec3::ZERO, DVec3::Y) }];
        let curve = Curve::new(images::Transfer::Linear);
        let folder = dir.path();
        let decode = Decode {
            frames: &frames,
            images: folder,
            masks: Some(folder),
            downscale: 1,
            curve,
            replay: String::new(),
            patience: Arc::default(),
        };
        let (stop, memory) = (StopSignal::new(), 1 << 30);
        let budget = Budget::new(Bytes(memory), &stop);
        let stage = Frames { groups: &[], decode: decode.clone(), budget: &budget, memory };
        let lent = stage.bytes(&frames[0]).unwrap();
        let why = decode.read(&frames[0], lent).unwrap_err().to_string();
        assert!(why.contains("a_mask.png: 400 x 300 pixels") && why.contains("the size of its photograph"), "{why}");
    }

    #[test]
    fn a_frame_that_could_never_be_read_says_what_it_takes() {
        let need = Need { peak: 3 << 30, held: 1 << 30 };
        assert_eq!(within(need, 3 << 30, 4 << 30), Ok(3 << 30));
        insta::assert_snapshot!(within(need, 1 << 30, 2 << 30).unwrap_err(), @r#"reading it takes 3 GiB of memory, and [run] memory = "2 GiB" leaves 1 GiB for it: raise the limit, or make the images smaller and set [decode] downscale"#);
    }
}
