//! Cast: frames become segments, a group of frames a unit.

mod causes;
mod frozen;
mod groups;
mod ingredients;
mod phase;
mod readable;
mod share;
mod trial;

pub(crate) use groups::{FrameGroups, opened_segments};
pub(crate) use phase::Cast;
pub(crate) use readable::Readable;
pub(crate) use readable::pixels;
