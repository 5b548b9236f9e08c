//! The one door for meshes.

use std::path::Path;

use super::ply;
use crate::base::Result;
use crate::scene::Mesh;

/// Reads a mesh.
///
/// # Errors
/// A file that cannot be read, or that is no mesh.
pub fn read_mesh(path: &Path) -> Result<Mesh> {
    ply::read_mesh(path)
}
