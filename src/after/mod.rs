//! What is looked at when a run is done: a frame's buffers, a triangle's map, a frame relit, how far the materials are from the
//! truth where one is known, how far pictures are from those that they should be.

mod exports;
mod finished;
mod held_out;
mod inspect;
mod judge;
mod pairs;
mod picture;
mod results;

pub(crate) use exports::export;
pub(crate) use held_out::HeldOut;
pub use inspect::read_maps;
pub(crate) use inspect::{buffers, maps};
pub(crate) use judge::{Judge, Judged, SUNS, judge};
pub(crate) use pairs::{ColorSpace, Compared, Pair, Unpaired, compare};
pub(crate) use picture::{Light, render};
pub use results::Results;
