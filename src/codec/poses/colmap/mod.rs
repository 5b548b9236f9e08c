//! COLMAP's sparse models: cameras and images, binary or text (COLMAP documentation, "Output Format").
//!
//! - A pose is world-to-camera: a quaternion (w, x, y, z) and a translation, which is not the camera's centre.
//! - The binary files count where both encodings are there. `rigs` and `frames`, which COLMAP writes since version 3.12,
//!   repeat what `images` says; they are not read, and neither are points.
//! - Ids need not be contiguous.
//! - Errors name the file and the number of the camera or image.

mod binary;
mod format;
mod models;
#[cfg(test)]
mod models_tests;
mod nearest;
mod posed;
#[cfg(test)]
mod tests;
mod text;
mod write;

pub use format::COLMAP;
pub(super) use format::only_camera;
pub(crate) use nearest::with_lenses_of_colmap;
pub use write::{Encoding, write_model};
