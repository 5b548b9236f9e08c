//! Cast: frames become segments, a group of frames a unit.

mod causes;
mod commits;
mod frozen;
mod groups;
mod ingredients;
mod phase;
mod readable;
mod share;
mod trial;

pub(crate) use causes::causes;
pub(crate) use commits::Commits;
pub(crate) use groups::{FrameGroups, Group, opened_segments};
pub(crate) use ingredients::image_in;
pub(crate) use phase::Cast;
pub(crate) use readable::Readable;
pub(crate) use readable::pixels;
