//! What light were photographs taken in, and how was each of them exposed? Found from what the frames saw of some triangles.

mod find;
mod gains;
mod observed;
mod sample;

pub(crate) use find::{Decision, Found, Scene, Settings, find};
pub(crate) use gains::{Gains, gains};
pub(crate) use observed::Sighting;
pub(crate) use sample::sample;
