//! Light: how the frames are exposed, and the light that they were taken in. Both are frozen once they are found.

mod ephemeris;
mod file;
mod found;
mod frozen;
mod known;
mod occasion;
mod phase;
mod sittings;
mod solve;

pub(crate) use file::{DOME, LIGHT};
pub(crate) use found::FoundLight;
pub(crate) use frozen::{FrozenLight, end_light};
pub(crate) use known::{lights_of, suns_of};
pub(crate) use occasion::{Occasion, middle_place, middle_time};
pub(crate) use phase::Light;
