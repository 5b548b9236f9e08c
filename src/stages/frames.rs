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
            Err(why) if is_broken(&why) => Need { peak: self.decode.bytes(frame) + HEADER, held: 0 },
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
    use super::*;

    #[test]
    fn a_frame_that_could_never_be_read_says_what_it_takes() {
        let need = Need { peak: 3 << 30, held: 1 << 30 };
        assert_eq!(within(need, 3 << 30, 4 << 30), Ok(3 << 30));
        insta::assert_snapshot!(within(need, 1 << 30, 2 << 30).unwrap_err(), @r#"reading it takes 3 GiB of memory, and [run] memory = "2 GiB" leaves 1 GiB for it: raise the limit, or make the images smaller and set [decode] downscale"#);
    }
}
