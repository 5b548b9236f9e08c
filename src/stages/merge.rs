//! Merge: the rows of all shards become two tables of a row a triangle, and triangles that were hardly seen are filled.

use std::io::Write;
use std::sync::Arc;

use super::fill::{self, fill};
use super::shards::RowsFile;
use crate::base::ids::{ShardId, TriangleId};
use crate::base::{Array, Bits, Error, Result};
use crate::codec::tables::npy::{self, NpyWriter};
use crate::config::{Effect, Former, Key, Keys, Now, Section, Settings, Value};
use crate::disk::{FileEntry, Store};
use crate::scene::Material;
use crate::scene::adjacency::Adjacency;
use crate::scene::evidence::{Evidence, Filled};
use crate::shard::Row;

/// Section `[merge]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// Whether triangles that were not seen are filled from their nearest seen neighbours; else they are NaN.
    pub fill: bool,
}

impl Section for Config {
    const NAME: &'static str = "merge";
    const ABOUT: &'static str = "How the materials of all triangles become one table.";
    const KEYS: &'static [Key] = &[Key {
        name: "fill",
        doc: "Whether triangles that were not seen take the material of their nearest seen neighbours; false leaves them NaN.",
        value: Value::Default("true"),
    }];
    const FORMER: &'static [Former] = &[Former { name: "min_bins", now: Now::Moved("[infer] min_bins") }];

    fn read(keys: &Keys<'_>) -> Self {
        Config { fill: keys.value("fill") }
    }

    fn settings(&self) -> Settings {
        let Config { fill } = self;
        Settings::of(Self::NAME).with("fill", fill, Effect::Merge)
    }
}

/// The version of the tables; an ingredient of their recipe.
pub(crate) const VERSION: u32 = 3;
/// The table of materials, [F,7].
pub(crate) const MATERIALS: &str = "materials.npy";
/// The table of the evidence behind them, [F,18].
pub(crate) const EVIDENCE: &str = "evidence.npy";

/// The most memory that merging holds for this many triangles, in bytes.
pub(crate) fn bytes(triangles: u64) -> u64 {
    // A shard's file is mapped, and its rows are held.
    fill::bytes(triangles) + triangles.min(u64::from(ShardId::TRIANGLES)) * size_of::<Row>() as u64 + BUFFERS
}

/// Bytes of the buffers of files being written.
const BUFFERS: u64 = 1 << 20;

/// Writes both tables, whose names must be free, for a mesh of `count` triangles. The shards must ascend. Given which triangles
/// touch, triangles that were hardly seen are filled. No table is held in memory: materials to be filled lie in the store's
/// scratch.
///
/// # Errors
/// A shard whose rows cannot be read or belong to another mesh; a table that cannot be written.
pub(crate) fn merge(
    store: &dyn Store,
    shards: &[RowsFile],
    count: usize,
    adjacency: Option<&Adjacency>,
) -> Result<Vec<FileEntry>> {
    let all = All { store, shards, count };
    let Some(adjacency) = adjacency else {
        let materials = all.table(MATERIALS, |row, _| row)?;
        return Ok(vec![materials, all.table(EVIDENCE, |_, evidence| evidence.to_array())?]);
    };
    let mut observed = Bits::new(count);
    let mut scratch = store.scratch()?;
    all.each(|t, row, evidence| {
        if evidence.filled == Filled::Observed {
            observed.insert(t);
        }
        scratch.write_all(bytemuck::bytes_of(&row)).map_err(Error::io("write", scratch.path()))
    })?;
    let mut scratch = scratch.work()?;
    let rows: &mut [[f32; Material::LEN]] = scratch.values()?;
    let sources = fill(adjacency, rows, observed);
    let materials = table(store, MATERIALS, count, |put| rows.iter().try_for_each(|&row| put(row)))?;
    drop(scratch);
    let evidence = table(store, EVIDENCE, count, |put| {
        all.each(|t, _, evidence| put(Evidence { filled: sources.of(t), ..evidence }.to_array()))
    })?;
    Ok(vec![materials, evidence])
}

/// The rows of all triangles.
struct All<'a> {
    store: &'a dyn Store,
    shards: &'a [RowsFile],
    count: usize,
}

impl All<'_> {
    /// Tells of every triangle in order. A triangle without a row in any shard has neither material nor evidence.
    fn each(&self, mut tell: impl FnMut(TriangleId, [f32; Material::LEN], Evidence) -> Result<()>) -> Result<()> {
        let nothing = Evidence {
            filled: Filled::Nothing,
            deviation: [f32::NAN; Material::LEN],
            lit: f32::NAN,
            ..Evidence::default()
        };
        let mut next = 0;
        for shard in self.shards {
            for Row { triangle, material, evidence } in shard.read(self.store)?.rows {
                if triangle.index() < next || triangle.index() >= self.count {
                    let shard = shard.shard;
                    return Err(Error::invalid(format!("shard {shard} is out of order, or goes past the mesh's end")));
                }
                (next..triangle.index())
                    .try_for_each(|t| tell(TriangleId::at(t), [f32::NAN; Material::LEN], nothing))?;
                tell(triangle, material, evidence)?;
                next = triangle.index() + 1;
            }
        }
        (next..self.count).try_for_each(|t| tell(TriangleId::at(t), [f32::NAN; Material::LEN], nothing))
    }

    /// Writes a table of the row that `row` makes of each triangle.
    fn table<const N: usize>(
        &self,
        name: &str,
        row: impl Fn([f32; Material::LEN], Evidence) -> [f32; N],
    ) -> Result<FileEntry> {
        table(self.store, name, self.count, |put| self.each(|_, material, evidence| put(row(material, evidence))))
    }
}

/// Writes a table of `count` rows. `rows` puts them into it.
fn table<const N: usize>(
    store: &dyn Store,
    name: &str,
    count: usize,
    rows: impl FnOnce(&mut dyn FnMut([f32; N]) -> Result<()>) -> Result<()>,
) -> Result<FileEntry> {
    let failed = |why| Error::io("write", store.path(name))(why);
    let mut out = NpyWriter::new(store.create(name)?, &[count, N]).map_err(failed)?;
    rows(&mut |row| out.write(&row).map_err(failed))?;
    out.finish().map_err(failed)?.replace()
}

/// The tables of a run, mapped: every triangle's material and evidence, in the mesh's order.
#[derive(Debug)]
pub struct Materials {
    /// Rows of `materials.npy`; NaN where there is none.
    pub rows: Array<[f32; Material::LEN]>,
    /// Rows of `evidence.npy`.
    pub evidence: Array<[f32; Evidence::LEN]>,
}

impl Materials {
    /// Opens the tables of a store.
    ///
    /// # Errors
    /// No such tables, or of different lengths.
    pub fn open(store: &dyn Store) -> Result<Materials> {
        let rows = npy::view(Arc::new(store.open(MATERIALS)?), &store.path(MATERIALS))?;
        let evidence: Array<[f32; Evidence::LEN]> = npy::view(Arc::new(store.open(EVIDENCE)?), &store.path(EVIDENCE))?;
        if rows.len() != evidence.len() {
            let found =
                format!("{} rows, and {MATERIALS} has {}: they belong to different runs", evidence.len(), rows.len());
            return Err(Error::malformed(store.path(EVIDENCE), found));
        }
        Ok(Materials { rows, evidence })
    }

    /// How many triangles have a material from each source, in the order of [`Filled`].
    pub fn counts(&self) -> [u64; 4] {
        let mut counts = [0; 4];
        self.evidence.iter().for_each(|row| counts[Evidence::from_array(*row).filled as usize] += 1);
        counts
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::base::ids::ShardId;
    use crate::disk::{DirStore, MemStore};
    use crate::scene::Mesh;
    use crate::shard::ShardRows;
    use glam::DVec3;

    const SHARD: u32 = ShardId::TRIANGLES;

    /// Shards of a strip of triangles, each touching the next: of triangle 2 too little was seen, of most nothing.
    fn strip(store: &dyn Store) -> (Vec<RowsFile>, Mesh) {
        let count = 2 * SHARD + 9;
        let corners: Vec<DVec3> = (0..count + 2).map(|i| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0)).collect();
        let mesh = Mesh::new(&corners, (0..count).map(|i| [i, i + 1, i + 2]).collect()).unwrap();
        let row = |t: u32, value: f32, filled| Row {
            triangle: TriangleId(t),
            material: [value; 7],
            evidence: Evidence { bins: 1.0 + t as f32, filled, ..Evidence::default() },
        };
        let own = |number: u32, rows: Vec<Row>| {
            let file = RowsFile { shard: ShardId(number), name: format!("{number}.rows") };
            ShardRows { shard: file.shard, rows }.write(store, &file.name).unwrap();
            file
        };
        let first = vec![row(0, 0.5, Filled::Observed), row(2, f32::NAN, Filled::Nothing)];
        (vec![own(0, first), own(2, vec![row(2 * SHARD + 8, 1.0, Filled::Observed)])], mesh)
    }

    fn merged(store: &dyn Store, (shards, mesh): &(Vec<RowsFile>, Mesh), fill: bool) -> Materials {
        let adjacency = fill.then(|| Adjacency::of(mesh));
        let files = merge(store, shards, mesh.len(), adjacency.as_ref()).unwrap();
        assert!(files.iter().all(|file| file.verify(store).is_ok()));
        Materials::open(store).unwrap()
    }

    #[test]
    fn rows_come_to_their_places_and_the_rest_is_filled_or_nan() {
        let dir = tempfile::tempdir().unwrap();
        let stores: [&dyn Store; 2] = [&MemStore::new(), &DirStore::new(dir.path())];
        for store in stores {
            let strip = strip(store);
            let plain = merged(store, &strip, false);
            assert_eq!(plain.counts(), [2, 0, 0, 2 * u64::from(SHARD) + 7]);
            [MATERIALS, EVIDENCE].iter().for_each(|name| store.remove(name).unwrap());
            let filled = merged(store, &strip, true);
            assert_eq!(filled.counts(), [2, 2 * u64::from(SHARD) + 7, 0, 0]);
            let end = 2 * SHARD as usize + 8;
            for t in 0..=end {
                let seen = [0, 2, end].contains(&t);
                assert_eq!(filled.evidence[t][2], if seen { 1.0 + t as f32 } else { 0.0 }, "{t}");
                assert_eq!(plain.evidence[t][..9], filled.evidence[t][..9], "{t}");
                assert_eq!(plain.rows[t][0].is_nan(), ![0, end].contains(&t), "{t}");
                // Halfway both are as near.
                let near = if t < end / 2 {
                    0.5
                } else if t > end / 2 {
                    1.0
                } else {
                    0.75
                };
                assert_eq!(filled.rows[t], [near; 7], "{t}");
            }
        }
        // Nothing but tables and shards is left.
        let store = DirStore::new(dir.path());
        assert_eq!((store.list("").unwrap().len(), store.sweep().unwrap().len()), (4, 0));
    }

    #[test]
    fn shards_out_of_order_or_past_the_end_are_refused() {
        let store = MemStore::new();
        let (mut shards, mesh) = strip(&store);
        let refusal = |shards: &[RowsFile], count| merge(&store, shards, count, None).unwrap_err().to_string();
        assert!(refusal(&shards, mesh.len() - 1).contains("past the mesh's end"));
        shards.reverse();
        assert!(refusal(&shards, mesh.len()).contains("out of order"));
        assert!(store.size(MATERIALS).unwrap().is_none());
    }
}
