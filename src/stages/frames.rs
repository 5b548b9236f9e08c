//! Frames: which are cast, in which order, and with how much memory each.
//!
//! A frame sets out only with the memory that reading it takes, which its file's header tells. Frames are served in
//! order, and one that has set out needs no more, nor does what the stages after it hold depend on it. So as long as
//! none is lent more than there is when no other is under way, all come through.

use super::decode::{Decode, Lent, skipped};
use super::gather::Group;
use crate::base::Result;
use crate::base::units::Bytes;
use crate::codec::image::Need;
use crate::flow::{Budget, Outlet, Source};

/// Produces the frames of groups, group after group.
pub struct Frames<'a> {
    /// The groups that are still to be done.
    pub groups: &'a [Group],
    /// What will read them.
    pub decode: Decode<'a>,
    /// What their memory is lent from.
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
            let posed = &self.decode.frames[frame as usize];
            let need = self.decode.need(posed).map_err(|why| why.to_string());
            let memory = match need.and_then(|need| within(need, self.memory, self.budget.total())) {
                Ok(bytes) => Ok(self.budget.reserve("frames", bytes)?),
                Err(why) => Err(skipped(posed, why, self.decode.replay)),
            };
            out.send(Lent { frame, memory })?;
        }
        Ok(())
    }
}

/// The bytes to lend, or why they are more than there will ever be.
fn within(need: Need, memory: u64, limit: u64) -> Result<u64, String> {
    let [needs, has, limit] = [need.peak, memory, limit].map(Bytes);
    let why = || {
        format!(
            "reading it takes {needs} of memory, and [run] memory = \"{limit}\" leaves {has} for it: give it more, or \
             make the images smaller and say so by [decode] downscale"
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
        insta::assert_snapshot!(within(need, 1 << 30, 2 << 30).unwrap_err(), @r#"reading it takes 3 GiB of memory, and [run] memory = "2 GiB" leaves 1 GiB for it: give it more, or make the images smaller and say so by [decode] downscale"#);
    }
}
