//! Look: what a frame saw of a sample of triangles. A triangle is projected into the frame, a few of its pixels are tried by rays,
//! and those are summed that see the triangle and nothing else nearby.

mod keep;
mod pixels;
mod sizes;
mod stage;

/// The version of how frames are looked at, and of the files that it leaves; an ingredient of their recipe.
pub(crate) const VERSION: u32 = 1;

pub(crate) use keep::{Keep, read_sightings, read_skipped, sightings_bytes};
pub(crate) use sizes::usual_pixels;
pub(crate) use stage::Look;
