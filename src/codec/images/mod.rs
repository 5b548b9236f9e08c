//! Photographs, masks and pictures, through the `image` crate: JPEG, PNG and TIFF of 8 and 16 bits, EXR, HDR.
//!
//! - Samples come out as narrow as they were stored, on the pixel grid that they were stored on. An EXIF orientation is
//!   never applied, since poses were solved without it. Grey becomes RGB. Pixels whose alpha is 0 are masked.
//! - The header tells how much memory an image takes ([`need()`]), so that the memory is set aside first. A header's claims
//!   are believed only within the size of the camera (65,535 pixels a side if there is none) and the memory that was set
//!   aside.

mod ended;
mod exposure;
mod exr;
mod hdr;
mod jpeg;
mod mask;
mod need;
mod other;
mod png;
mod read;
mod size;
mod taken;
#[cfg(test)]
mod tests;
mod tiff;
mod transfer;
mod write;

pub(crate) use exposure::Exposure;
pub(crate) use mask::mask_path;
pub(crate) use need::Need;
pub use read::{Encoded, need, read_image, size};
pub(crate) use read::{is_picture, mask_need};
pub use size::Size;
#[cfg(test)]
pub(crate) use taken::tests as exif_made;
pub(crate) use taken::{Taken, taken};
pub use transfer::{Curve, Transfer};
pub(crate) use transfer::{to_srgb, to_srgb8};
pub(crate) use write::encode_png;
pub(crate) use write::write_jpeg_taken;
pub use write::{write_jpeg, write_png};
