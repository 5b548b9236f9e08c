//! Which exposure and which light were the photographs taken in? Found from what frames saw of a sample of triangles.
//!
//! - [`sittings()`]: which frames were taken in one light.
//! - [`vignetting()`]: how much darker cameras are towards their corners.
//! - [`gains()`]: one factor a frame, from triangles that several frames see.
//! - [`find`]: the sun's direction and the ratio of sky to sun, from pairs of triangles that are alike but for their light:
//!   under the right light their albedos agree. The scale is a convention, since a brighter sun and whiter walls look the same.
//! - `ephemeris`: where the sun stands by place and time, which leaves ratio and scale to be found ([`Clues::under`]).
//!
//! Nothing here reads a file. Work is shared out by rayon, but sums run in one order, so that answers do not depend on the
//! number of threads; nothing is random.

mod blocks;
mod clues;
mod comparison;
mod decision;
mod directions;
mod draw;
pub(crate) mod ephemeris;
mod found;
mod gains;
mod likeness;
mod observed;
mod pairs;
mod patches;
mod ratio;
mod rows;
mod sample;
mod scale;
mod search;
mod sittings;
mod spread;
#[cfg(test)]
mod tests;
mod tied;
mod vignetting;
mod weights;

pub use clues::{Clues, Settings, find};
pub use found::{Decision, Found, Spread};
pub use gains::{Gains, gains};
pub use observed::Sighting;
pub(crate) use observed::luma;
pub use patches::Scene;
pub use sample::{TRIANGLES, sample};
pub(crate) use sittings::sittings;
pub(crate) use vignetting::vignetting;
