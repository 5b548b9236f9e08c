//! glTF 2.0 in one binary file, a texel a triangle.

use super::exporter::{Exporter, Surface};
use crate::base::Result;
use crate::codec::meshes::glb;
use crate::disk::{FileEntry, Store};

const FILE: &str = "export/scene.glb";

/// The exporter.
pub(super) const GLB: Exporter =
    Exporter { name: "glb", version: 2, files: &[FILE], turns_axes: true, bytes_per_triangle: 100, write };

fn write(surface: &Surface<'_>, store: &dyn Store) -> Result<Vec<FileEntry>> {
    let mut draft = store.create(FILE)?;
    let path = draft.path().to_owned();
    glb::write(&mut draft, &path, surface.mesh, &surface.materials.rows, surface.up, surface.place.as_ref())?;
    Ok(vec![draft.replace()?])
}
