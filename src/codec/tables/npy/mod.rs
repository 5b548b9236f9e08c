//! NumPy's `.npy`: one array of floating point numbers, row-major.
//!
//! Layout (NEP 1): `\x93NUMPY`, version `1 0`, `u16` length of the header, the header, then the values, little endian.
//! The header is a Python literal padded with spaces so that the values start at a multiple of 64 bytes: numpy and other
//! programs can map the file as it is.
//!
//! ```text
//! {'descr': '<f4', 'fortran_order': False, 'shape': (3, 7), }
//! ```
//!
//! Written: version 1, `<f4`, or `<f2` on request. Read: versions 1 to 3, `<f4` and `<f8` (rounded to f32), row-major. The
//! shape in the header is a claim: it is checked against the length of the file before anything is allocated.

mod header;
pub(crate) mod read;
#[cfg(test)]
mod tests;
mod write;

pub(crate) use header::heading;
pub use read::{read_rows, view};
pub(crate) use write::NpyWriter;
