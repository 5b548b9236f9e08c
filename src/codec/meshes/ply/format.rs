//! The format PLY: read by its header, as text or as bytes.

use std::io::{BufReader, Seek};

use super::header::{Encoding, Header};
use super::{ascii, binary};
use crate::base::input::Input;
use crate::base::{Error, Result};
use crate::codec::meshes::format::{MeshFormat, alone};
use crate::scene::survey::Polygons;

/// The Stanford polygon format. Vertices are read in f64 whatever their type.
pub(crate) const PLY: MeshFormat = MeshFormat {
    name: "PLY",
    endings: &["ply"],
    begins: |start| matches!(start.strip_prefix(b"ply"), Some([b'\n' | b'\r' | b' ' | b'\t', ..])),
    beside: alone,
    tell,
};

/// Looks at the header of a file.
///
/// # Errors
/// A header that is none of a mesh.
pub(crate) fn look(file: &mut Input) -> Result<()> {
    let (path, length) = (&file.path().to_owned(), file.length());
    file.rewind().map_err(Error::io("read", path))?;
    Header::read(&mut BufReader::new(file), length, path).map(drop)
}

fn tell(file: &mut Input, to: &mut dyn Polygons) -> Result<()> {
    let (path, length) = (&file.path().to_owned(), file.length());
    let mut reader = BufReader::with_capacity(1 << 18, file);
    let header = Header::read(&mut reader, length, path)?;
    match header.encoding {
        Encoding::Ascii => ascii::read(&header, reader, path, to),
        Encoding::Binary(endian) => binary::read(&header, endian, reader, path, to),
    }
}
