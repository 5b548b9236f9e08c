//! What a mesh format is to the rest of gonio.

use std::path::PathBuf;

use crate::base::Result;
use crate::base::input::Input;
use crate::scene::survey::Polygons;

/// A format of triangle meshes that is read.
#[derive(Debug, Clone, Copy)]
pub(crate) struct MeshFormat {
    /// The format's name, as people write it.
    pub name: &'static str,
    /// The endings of its files' names, in lower case, without the dot.
    pub endings: &'static [&'static str],
    /// Whether a file that begins with these bytes is of the format, whatever its name is. The bytes are the first 64, or
    /// fewer if the file has no more.
    pub begins: fn(&[u8]) -> bool,
    /// The files that a file of the format names, which have parts of the mesh; none for most formats.
    pub beside: fn(&mut Input) -> Result<Vec<PathBuf>>,
    /// Tells every vertex and face, in the file's order. A mesh is read in passes: this is called two or three times, so that
    /// nothing but the mesh is held, each time with the file at its first byte. Its errors name the position of a fault in
    /// the file.
    pub tell: fn(&mut Input, &mut dyn Polygons) -> Result<()>,
}

/// A file that names no others.
pub(super) fn alone(_: &mut Input) -> Result<Vec<PathBuf>> {
    Ok(Vec::new())
}
