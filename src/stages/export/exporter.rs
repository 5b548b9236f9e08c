//! What an export is to the rest of gonio.

use glam::DVec3;

use crate::base::Result;
use crate::base::ids::TriangleId;
use crate::codec::images::to_srgb8;
use crate::disk::{FileEntry, Store};
use crate::scene::georeference::Georeference;
use crate::scene::{Material, Mesh};
use crate::stages::merge::Materials;

/// A format that materials are exported in: a name in `[export] formats`.
#[derive(Debug, Clone, Copy)]
pub struct Exporter {
    /// The format's name in a pipeline file.
    pub name: &'static str,
    /// The version of what the exporter writes; an ingredient of its unit's recipe.
    pub version: u32,
    /// The names of the files that only this exporter writes, in the run's store.
    pub files: &'static [&'static str],
    /// Whether the exporter turns the mesh to axes of its own, so that its files depend on `[scene] up`.
    pub turns_axes: bool,
    /// The bytes that the files take on the disk, for each triangle, at most.
    pub bytes_per_triangle: u64,
    /// Writes the files, whose names must be free.
    pub write: fn(&Surface<'_>, &dyn Store) -> Result<Vec<FileEntry>>,
}

/// Exporters are equal if their names are.
impl PartialEq for Exporter {
    fn eq(&self, other: &Self) -> bool {
        self.name == other.name
    }
}

/// A mesh with all that was found out about it.
pub struct Surface<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The tables, a row a triangle.
    pub materials: &'a Materials,
    /// The way up in the mesh's coordinates.
    pub up: DVec3,
    /// Where on the earth the mesh lies, if it is known.
    pub place: Option<Georeference>,
}

/// The sRGB value of what has no material.
const UNKNOWN: u8 = 128;

impl Surface<'_> {
    /// The diffuse colour of a triangle, 8-bit sRGB; grey where the triangle has no material. Exports ask for colours here alone,
    /// since a triangle may come to have more than one.
    pub fn color(&self, triangle: TriangleId) -> [u8; 3] {
        let shade = |kd: f32| if kd.is_nan() { UNKNOWN } else { to_srgb8(kd) };
        Material::from(self.materials.rows[triangle.index()]).kd.map(shade)
    }
}
