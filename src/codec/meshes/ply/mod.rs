//! PLY, the Stanford polygon format (Turk 1994), read and written.
//!
//! Layout: a text header (`ply`, `format ascii|binary_little_endian|binary_big_endian 1.0`, then elements with their
//! counts and properties, `end_header`), then the elements in the header's order, without padding. A list property is
//! its length and then that many items.
//!
//! Read: element `vertex` with scalars `x`, `y`, `z` of any type, element `face` with a list `vertex_indices` or
//! `vertex_index` of any integer types. The two may come in any order; other elements and properties are skipped.
//!
//! A face of n corners becomes n - 2 triangles, one of fewer than three none. A triangle's id is its position AFTER that, in file order: in a mesh of
//! triangles alone it is the face's position in the file, counted from 0.

mod ascii;
mod binary;
mod faces;
mod format;
mod header;
mod scalar;
#[cfg(test)]
mod tests;
mod write;

pub(crate) use format::{PLY, look};
pub use write::write_mesh;
pub(crate) use write::write_with;
pub(crate) use write::{FaceColumn, Values};
