//! Makes a mesh of what a format tells.

use std::path::Path;

use super::format::MeshFormat;
use crate::base::{Error, Result};
use crate::scene::Mesh;
use crate::scene::mesh::MeshError;
use crate::scene::survey::Survey;

/// Reads a mesh in two passes over its file: the first finds how many bytes the mesh takes, the second, if `may` allows
/// so many, holds them.
///
/// # Errors
/// Those of the format; what is told makes no mesh; the answer of `may`.
pub(super) fn read(format: &MeshFormat, path: &Path, may: &dyn Fn(u64) -> Result<()>) -> Result<Mesh> {
    let wrong = |why: MeshError| Error::malformed(path, why.to_string());
    let mut survey = Survey::default();
    (format.tell)(path, &mut survey)?;
    may(survey.bytes())?;
    let mut filling = survey.filling().map_err(wrong)?;
    (format.tell)(path, &mut filling)?;
    filling.finish().map_err(wrong)
}
