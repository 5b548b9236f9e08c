//! Photographs, masks and pictures, through the `image` crate: JPEG, PNG and TIFF of 8 and 16 bits, EXR, HDR.
//!
//! - Samples come out as narrow as they were stored, on the pixel grid that they were stored on. An EXIF orientation is
//!   never applied, since poses were solved without it. Grey becomes RGB. A photograph's alpha is dropped; a picture that
//!   is compared ([`read_picture`]) is masked where its alpha is 0.
//! - The header tells how much memory an image takes ([`need()`]), so that the memory is set aside first. A header's claims
//!   are believed only within the size of the camera (65,535 pixels a side if there is none) and the memory that was set
//!   aside.

mod exr;
mod hdr;
mod jpeg;
mod need;
mod png;
mod read;
mod size;
#[cfg(test)]
mod tests;
mod tiff;
mod transfer;
mod write;

pub(crate) use need::Need;
pub use read::{Encoded, need, read_image, read_picture, size};
pub(crate) use read::{is_picture, mask_need, mask_path};
pub use size::Size;
pub use transfer::{Curve, Transfer};
pub(crate) use transfer::{to_srgb, to_srgb8};
pub(crate) use write::encode_png;
pub use write::{write_jpeg, write_png};
