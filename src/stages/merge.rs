//! Merge: the materials of all shards become one row a triangle, and what was hardly seen is filled.

use serde::Serialize;

use super::Fault;
use super::fill::fill;
use super::shards::Shard;
use crate::base::{Error, Result};
use crate::codec::npy::NpyWriter;
use crate::disk::{FileEntry, Store};
use crate::scene::Material;
use crate::scene::adjacency::Adjacency;
use crate::scene::evidence::{Evidence, Filled};
use crate::scene::reflectance::FRONT_BINS;

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

/// The unit of both tables.
pub const TABLES: &str = "tables";
/// Version of what this stage makes of the shards' rows; part of the tables' recipe.
pub const VERSION: u32 = 1;
/// The table of materials, [F,7].
pub const MATERIALS: &str = "materials.npy";
/// The table of what stands behind them, [F,10].
pub const EVIDENCE: &str = "evidence.npy";

impl Materials {
    /// Bytes of memory per triangle.
    pub const BYTES_PER_TRIANGLE: u64 = (size_of::<[f32; Material::LEN]>() + size_of::<Evidence>()) as u64;

    /// Puts every shard's rows in their place among those of `count` triangles; then, if it is known which of them touch,
    /// fills what was hardly seen.
    ///
    /// # Errors
    /// A shard whose rows cannot be read or are not those of this mesh.
    pub fn merge(
        store: &dyn Store,
        shards: &[Shard],
        count: usize,
        adjacency: Option<&Adjacency>,
    ) -> Result<Materials> {
        let nothing = Evidence { filled: Filled::Nothing, ..Evidence::default() };
        let mut all = Materials { rows: vec![[f32::NAN; Material::LEN]; count], evidence: vec![nothing; count] };
        for shard in shards {
            for (triangle, material, evidence) in shard.rows(store)?.rows {
                let at = triangle as usize;
                if at >= count {
                    return Err(Error::invalid(format!("shard {} goes past the mesh's end", shard.number)));
                }
                (all.rows[at], all.evidence[at]) = (material, evidence);
            }
        }
        if let Some(adjacency) = adjacency {
            fill(adjacency, &mut all.rows, &mut all.evidence);
        }
        Ok(all)
    }

    /// Writes both tables. Their names must be free.
    pub fn write(&self, store: &dyn Store) -> Result<Vec<FileEntry>> {
        let materials = table(store, MATERIALS, self.rows.iter().copied())?;
        Ok(vec![materials, table(store, EVIDENCE, self.evidence.iter().map(|e| e.to_array()))?])
    }
}

fn table<const N: usize>(
    store: &dyn Store,
    name: &str,
    rows: impl ExactSizeIterator<Item = [f32; N]>,
) -> Result<FileEntry> {
    let draft = store.create(name)?;
    let write = || {
        let mut out = NpyWriter::new(draft, &[rows.len(), N])?;
        rows.into_iter().try_for_each(|row| out.write(&row)).and_then(|()| out.finish())
    };
    write().map_err(Error::io("write", store.path(name)))?.commit()
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
