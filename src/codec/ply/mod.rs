//! PLY, the Stanford polygon format (Turk 1994), read and written.
//!
//! Layout: a text header (`ply`, `format ascii|binary_little_endian|binary_big_endian 1.0`, then elements with their
//! counts and properties, `end_header`), then the elements in the header's order, without padding. A list property is
//! its length followed by that many items.
//!
//! Read: element `vertex` with scalars `x`, `y`, `z` of any type, element `face` with a list `vertex_indices` or
//! `vertex_index` of any integer types. The two may come in any order; other elements and properties are skipped.
//!
//! Faces of n corners become fans of n - 2 triangles around their first corner. A triangle's id is its position AFTER
//! that, in file order: in a mesh of triangles alone it is the face's position in the file, counted from 0.

mod ascii;
mod binary;
mod faces;
mod header;
mod scalar;
#[cfg(test)]
mod tests;
mod write;

use std::fs::File;
use std::io::BufReader;
use std::path::Path;

use super::mesh::in_two_passes;
use crate::base::{Error, Result};
use crate::scene::Mesh;
use crate::scene::survey::Polygons;
use header::{Format, Header};

pub use write::{FaceColumn, Values, write_mesh};

/// Reads a mesh, in two passes over the file, so that nothing is held but the mesh. Vertices are read in f64 whatever
/// their type; the mesh keeps f32 about an f64 origin.
///
/// # Errors
/// If the file cannot be read or is truncated; if there are no faces, a face has fewer than three corners or refers to
/// a vertex that is not there, a coordinate is not finite: with the element's position, counted from 0.
pub fn read_mesh(path: &Path) -> Result<Mesh> {
    read(path, &|_| Ok(()))
}

/// The same, if the mesh may be held.
///
/// # Errors
/// The same, and what `may` answers.
pub(super) fn read(path: &Path, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
    in_two_passes(path, may, |to| tell(path, to))
}

/// Reads the file once.
fn tell(path: &Path, to: &mut dyn Polygons) -> Result<()> {
    let (header, reader) = open(path)?;
    match header.format {
        Format::Ascii => ascii::read(&header, reader, path, to),
        Format::Binary(endian) => binary::read(&header, endian, reader, path, to),
    }
}

fn open(path: &Path) -> Result<(Header, BufReader<File>)> {
    let file = File::open(path).map_err(Error::io("open", path))?;
    let length = file.metadata().map_err(Error::io("read", path))?.len();
    let mut reader = BufReader::with_capacity(1 << 18, file);
    let header = Header::read(&mut reader, length, path)?;
    Ok((header, reader))
}
