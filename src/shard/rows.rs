//! The rows of one shard: what was inferred of its triangles. A sealed file, version 3. Integers and floats are little endian.
//!
//! ```text
//! shard   u32
//! rows    u32
//! row     one per triangle that was observed, ascending: triangle u32, 7 f32 of `scene::Material` (NaN where there was
//!         too little evidence), 18 f32 of `scene::evidence::Evidence`
//! ```

use std::io::Write;

use super::format::u32_at;
use crate::base::convert::to_u32;
use crate::base::ids::{ShardId, TriangleId};
use crate::base::{Error, Result};
use crate::disk::{FileEntry, Seal, Store};
use crate::scene::Material;
use crate::scene::evidence::Evidence;

const SEAL: Seal = Seal { magic: *b"GONIOROW", version: VERSION, kind: "shard of materials" };

/// Version of the layout above; part of every shard's key.
pub const VERSION: u32 = 3;

/// Bytes of shard and rows.
const HEADER: usize = 8;

/// Bytes of a row.
pub const ROW: usize = 4 * (1 + Material::LEN + Evidence::LEN);

/// What was inferred of one triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Row {
    /// The triangle.
    pub triangle: TriangleId,
    /// The triangle's material; NaN where there is too little evidence.
    pub material: [f32; Material::LEN],
    /// The evidence behind the material.
    pub evidence: Evidence,
}

/// The rows of one shard.
#[derive(Debug, Clone, PartialEq)]
pub struct ShardRows {
    /// The shard.
    pub shard: ShardId,
    /// The rows of the observed triangles, ascending.
    pub rows: Vec<Row>,
}

impl ShardRows {
    /// Writes the rows under this name.
    pub fn write(&self, store: &dyn Store, name: &str) -> Result<FileEntry> {
        let mut bytes = Vec::with_capacity(HEADER + self.rows.len() * ROW);
        bytes.extend(self.shard.0.to_le_bytes());
        bytes.extend(to_u32(self.rows.len()).to_le_bytes());
        for Row { triangle, material, evidence } in &self.rows {
            bytes.extend(triangle.0.to_le_bytes());
            bytes.extend(material.iter().chain(&evidence.to_array()).flat_map(|v| v.to_le_bytes()));
        }
        let mut out = SEAL.create(store, name)?;
        out.write_all(&bytes).map_err(Error::io("write", store.path(name)))?;
        out.seal()
    }

    /// Reads the rows of this shard from the file of this name.
    ///
    /// # Errors
    /// A file that does not hold rows of this shard.
    pub fn read(store: &dyn Store, name: &str, shard: ShardId) -> Result<ShardRows> {
        let bytes = SEAL.open(store, name)?;
        let wrong = |found: String| Error::malformed(store.path(name), found);
        let (header, body) = bytes.split_at_checked(HEADER).ok_or_else(|| wrong("it has no header".into()))?;
        let (rows, rest) = body.as_chunks::<ROW>();
        if u32_at(header, 0) != shard.0 || u32_at(header, 4) as usize != rows.len() || !rest.is_empty() {
            let (found, said) = (u32_at(header, 0), u32_at(header, 4));
            return Err(wrong(format!("shard {found} with {said} rows in {} bytes; wanted is {shard}", body.len())));
        }
        let rows: Vec<Row> = rows.iter().map(row).collect();
        let own = |row: &Row| row.triangle != TriangleId::NONE && row.triangle.shard() == shard;
        if !rows.is_sorted_by(|a, b| a.triangle < b.triangle) || !rows.iter().all(own) {
            return Err(wrong("its triangles do not ascend, or are not of its shard".into()));
        }
        Ok(ShardRows { shard, rows })
    }
}

fn row(bytes: &[u8; ROW]) -> Row {
    let at = |column: usize| f32::from_bits(u32_at(bytes, 4 * (1 + column)));
    let evidence = Evidence::from_array(std::array::from_fn(|c| at(Material::LEN + c)));
    Row { triangle: TriangleId(u32_at(bytes, 0)), material: std::array::from_fn(at), evidence }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::MemStore;
    use crate::scene::evidence::Filled;

    const SHARD: u32 = ShardId::TRIANGLES;

    fn rows(shard: u32, triangles: &[u32]) -> ShardRows {
        let evidence = Evidence { frames: 3.0, filled: Filled::Observed, ..Evidence::default() };
        let row = |&t: &u32| Row {
            triangle: TriangleId(t),
            material: std::array::from_fn(|c| t as f32 + c as f32 / 8.0),
            evidence,
        };
        ShardRows { shard: ShardId(shard), rows: triangles.iter().map(row).collect() }
    }

    #[test]
    fn what_is_written_is_read() {
        let store = MemStore::new();
        for (name, rows) in [("a", rows(2, &[2 * SHARD, 2 * SHARD + 9, 3 * SHARD - 1])), ("b", rows(0, &[]))] {
            rows.write(&store, name).unwrap();
            assert_eq!(ShardRows::read(&store, name, rows.shard).unwrap(), rows);
        }
    }

    #[test]
    fn another_shard_and_every_cut_and_flip_are_refused() {
        let store = MemStore::new();
        for (name, rows) in [("a", rows(1, &[0])), ("b", rows(1, &[SHARD + 1, SHARD + 1])), ("c", rows(0, &[1]))] {
            rows.write(&store, name).unwrap();
            assert!(ShardRows::read(&store, name, ShardId(1)).is_err());
        }
        rows(1, &[SHARD, SHARD + 4]).write(&store, "whole").unwrap();
        let whole = store.open("whole").unwrap().to_vec();
        let believed = |bytes: &[u8]| {
            let mut draft = store.create("torn").unwrap();
            draft.write_all(bytes).unwrap();
            draft.replace().unwrap();
            ShardRows::read(&store, "torn", ShardId(1)).is_ok()
        };
        assert!(believed(&whole));
        assert!(!(0..whole.len()).any(|cut| believed(&whole[..cut])));
        for bit in 0..8 * whole.len() {
            let mut flipped = whole.clone();
            flipped[bit / 8] ^= 1 << (bit % 8);
            assert!(!believed(&flipped), "bit {bit}");
        }
    }
}
