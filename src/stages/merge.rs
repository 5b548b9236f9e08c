//! Merge: the materials of all shards become one row a triangle, and what was hardly seen is filled.

use serde::Serialize;

use super::Fault;
use super::fill::fill;
use super::infer::ShardMaterials;
use crate::base::Result;
use crate::flow::{End, Fold, Meter};
use crate::scene::adjacency::Adjacency;
use crate::scene::evidence::{Evidence, Filled};
use crate::scene::reflectance::FRONT_BINS;
use crate::scene::{Material, Mesh};

/// Section `[merge]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// Bins that a triangle's map must have filled for its material to count, 1 to 3,600.
    pub min_bins: u32,
    /// Whether triangles with less are filled from their nearest observed neighbours; else they are NaN.
    pub fill: bool,
}

impl Default for Config {
    fn default() -> Self {
        Config { min_bins: 1, fill: true }
    }
}

impl Config {
    /// What is wrong with it.
    pub fn check(&self) -> Vec<Fault> {
        Fault::unless_within("min_bins", self.min_bins, 1..=FRONT_BINS as u32).into_iter().collect()
    }
}

/// The material of every triangle and what stands behind it, in the mesh's order.
#[derive(Debug, Clone, PartialEq)]
pub struct Materials {
    /// Rows of `materials.npy`; NaN where there is none.
    pub rows: Vec<[f32; Material::LEN]>,
    /// Rows of `evidence.npy`.
    pub evidence: Vec<Evidence>,
}

impl Materials {
    /// How many triangles have a material from this source.
    pub fn count(&self, filled: Filled) -> u64 {
        self.evidence.iter().filter(|e| e.filled == filled).count() as u64
    }
}

/// Puts every shard's answers in their place, then fills what was hardly seen.
pub struct Merge<'a> {
    mesh: &'a Mesh,
    fill: bool,
    all: Materials,
}

impl<'a> Merge<'a> {
    /// Materials for this mesh, none so far.
    pub fn new(mesh: &'a Mesh, fill: bool) -> Self {
        let nothing = Evidence { filled: Filled::Nothing, ..Evidence::default() };
        let all = Materials { rows: vec![[f32::NAN; Material::LEN]; mesh.len()], evidence: vec![nothing; mesh.len()] };
        Merge { mesh, fill, all }
    }

    /// Bytes of memory that it holds, per triangle.
    pub const BYTES_PER_TRIANGLE: u64 = (size_of::<[f32; Material::LEN]>() + size_of::<Evidence>()) as u64;
}

impl Fold for Merge<'_> {
    type In = ShardMaterials;
    type Out = Materials;

    fn take(&mut self, shard: ShardMaterials, _: &Meter) -> Result<()> {
        for (triangle, material, evidence) in shard.0 {
            self.all.rows[triangle as usize] = material;
            self.all.evidence[triangle as usize] = evidence;
        }
        Ok(())
    }

    fn finish(mut self, end: End, _: &Meter) -> Result<Materials> {
        if self.fill && end == End::Complete {
            fill(&Adjacency::of(self.mesh), &mut self.all.rows, &mut self.all.evidence);
        }
        Ok(self.all)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn no_map_fills_more_than_its_front() {
        for (min_bins, faults) in [(0, 1), (1, 0), (3600, 0), (3601, 1)] {
            assert_eq!(Config { min_bins, ..Config::default() }.check().len(), faults, "{min_bins}");
        }
    }
}
