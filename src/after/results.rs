//! The tables of a finished run, triangle by triangle.

use crate::base::Result;
use crate::base::ids::TriangleId;
use crate::disk::DirStore;
use crate::pipeline::Pipeline;
use crate::scene::Material;
use crate::scene::evidence::Evidence;
use crate::stages::merge::Materials;

/// The materials of a finished run and the evidence behind them, mapped from its folder.
#[derive(Debug)]
pub struct Results(Materials);

impl Results {
    /// Opens the tables of a finished run.
    ///
    /// # Errors
    /// No such tables, or tables of different lengths.
    pub fn open(pipeline: &Pipeline) -> Result<Self> {
        Materials::open(&DirStore::new(&pipeline.run.work)).map(Results)
    }

    /// The number of triangles of the mesh.
    pub fn len(&self) -> usize {
        self.0.rows.len()
    }

    /// Whether the mesh has no triangle.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// The material of a triangle; `None` past the end of the mesh, and where the triangle has none.
    pub fn material(&self, triangle: TriangleId) -> Option<Material> {
        self.0.rows.get(triangle.index()).map(|row| Material::from(*row)).filter(|material| !material.r.is_nan())
    }

    /// The evidence behind a triangle's material; `None` past the end of the mesh.
    pub fn evidence(&self, triangle: TriangleId) -> Option<Evidence> {
        self.0.evidence.get(triangle.index()).map(|row| Evidence::from_array(*row))
    }
}
