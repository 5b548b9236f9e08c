//! Runs a pipeline.

use std::path::{Path, PathBuf};

use super::{Pipeline, Progress, Report};
use crate::base::ids::TriangleId;
use crate::base::{Error, Result};
use crate::flow::StopSignal;

/// Runs or resumes the pipeline to its end.
///
/// # Errors
/// Whatever breaks the run; `Error::Interrupted` if it was asked to stop.
pub fn run(pipeline: &Pipeline, _stop: &StopSignal, _progress: &Progress) -> Result<Report> {
    Err(not_wired(pipeline))
}

/// Writes the buffers of one frame as a multi-channel EXR.
///
/// # Errors
/// No frame of that name; anything that cannot be read or written.
pub fn buffers(pipeline: &Pipeline, _frame: &str, _out: &Path) -> Result<()> {
    Err(not_wired(pipeline))
}

/// Writes the reflectance maps of these triangles, as `.npz` or as one `.png`, by the name of `out`.
///
/// # Errors
/// A triangle that the mesh does not have; no finished segments; anything that cannot be read or written.
pub fn maps(pipeline: &Pipeline, _triangles: &[TriangleId], _out: &Path) -> Result<()> {
    Err(not_wired(pipeline))
}

/// Writes the exports again from the materials of a finished run, and gives their paths.
///
/// # Errors
/// No finished materials; anything that cannot be read or written.
pub fn export(pipeline: &Pipeline) -> Result<Vec<PathBuf>> {
    Err(not_wired(pipeline))
}

fn not_wired(pipeline: &Pipeline) -> Error {
    Error::invalid("not wired yet").doing(format!("running {}", pipeline.file.display()))
}
