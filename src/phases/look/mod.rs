//! Look: what the frames saw of a sample of triangles, a group of frames a unit. Exposures and light are found of it.

mod phase;
mod seen;

pub(crate) use phase::Look;
pub(crate) use seen::Seen;
