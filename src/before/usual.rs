//! What may be in a project's folder: the formats that are read, and where files are looked for that are still to be made.

use crate::codec::poses::FORMATS;

/// Where a mesh is looked for that is to be made.
pub(super) const MESH: &str = "dense/meshed-poisson.ply";

/// Where photographs are looked for that are to be put there.
pub(super) const IMAGES: &str = "images";

/// Where poses are looked for that are to be made.
pub(super) const POSES: &str = "sparse/0";

/// The formats of poses that are read.
pub(super) fn formats() -> String {
    let known: Vec<String> = FORMATS.iter().map(|format| format!("{} ({})", format.name, format.programs)).collect();
    format!("gonio reads the poses of {}", known.join(", "))
}
