//! Tests of gains, samples and the whole search, on made-up rows and on scenes with a closed form.

mod flight;
mod gains;
mod light;
mod sample;
mod sittings;
mod town;
mod vignetting;
