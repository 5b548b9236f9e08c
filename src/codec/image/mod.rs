//! Photographs and masks, through the `image` crate: JPEG, PNG and TIFF of 8 and 16 bits, EXR, HDR.
//!
//! - Samples come out as narrow as they were stored, on the pixel grid that they were stored on: an EXIF orientation is
//!   never applied, since poses were solved without it. Grey becomes RGB. A photograph's alpha is dropped; a picture that
//!   is to be compared ([`read_picture`]) is masked where its alpha is 0.
//! - What reading an image takes is known from its header ([`need`]), so that memory for it is set aside first. What a
//!   header claims is believed only within the size that the camera says (65,535 pixels a side where none does) and the
//!   memory that was set aside.

mod exr;
mod jpeg;
mod need;
mod read;
#[cfg(test)]
mod tests;
mod transfer;
mod write;

pub use need::Need;
pub use read::{is_picture, mask_need, mask_path, need, read_image, read_mask, read_picture, size};
pub use transfer::{Curve, Transfer, to_srgb, to_srgb8};
pub use write::{write_jpeg, write_png};
