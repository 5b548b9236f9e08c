//! The content hashes of the blocks in a map unit's segments. The keys of shards are made of these hashes, wherever the
//! blocks lie later. A sealed file, version 1. Integers are little endian.
//!
//! ```text
//! block   one per block, ascending by shard: shard u32, hash 16 bytes as in the segment's index
//! ```

use super::format::{Entry, Hash, u32_at};
use crate::base::ids::ShardId;
use crate::base::{Error, Result};
use crate::disk::{FileEntry, Seal, Sealed, Store};

const SEAL: Seal = Seal { magic: *b"GONIOBLK", version: 1, kind: "list of blocks" };

/// Bytes of a block's line.
const LINE: usize = 20;

/// The list of the blocks of one map unit.
#[derive(Debug)]
pub struct Blocks(Sealed);

impl Blocks {
    /// Writes the list of these blocks, in any order, under this name.
    pub(crate) fn write(store: &dyn Store, name: &str, entries: &[Entry]) -> Result<FileEntry> {
        let mut lines: Vec<(ShardId, Hash)> = entries.iter().map(|e| (e.shard, e.hash)).collect();
        lines.sort_unstable();
        let mut out = SEAL.create(store, name)?;
        for (shard, hash) in lines {
            let line = [&shard.0.to_le_bytes()[..], &hash].concat();
            std::io::Write::write_all(&mut out, &line).map_err(Error::io("write", store.path(name)))?;
        }
        out.seal()
    }

    /// Opens the list under this name.
    ///
    /// # Errors
    /// A file that is not such a list.
    pub fn open(store: &dyn Store, name: &str) -> Result<Blocks> {
        let blocks = Blocks(SEAL.open(store, name)?);
        let (lines, rest) = blocks.0.as_chunks::<LINE>();
        if !rest.is_empty() || !lines.is_sorted_by_key(|line| u32_at(line, 0)) {
            return Err(Error::malformed(store.path(name), "the blocks do not ascend"));
        }
        Ok(blocks)
    }

    /// The hashes of a shard's blocks.
    pub fn of(&self, shard: ShardId) -> impl Iterator<Item = Hash> {
        let (lines, _) = self.0.as_chunks::<LINE>();
        let start = lines.partition_point(|line| u32_at(line, 0) < shard.0);
        lines[start..].iter().take_while(move |line| u32_at(*line, 0) == shard.0).map(|line| {
            let mut hash = Hash::default();
            hash.copy_from_slice(&line[4..]);
            hash
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::MemStore;

    fn entry(shard: u32, n: u8) -> Entry {
        Entry { shard: ShardId(shard), triangles: 1, records: 1, crc: 0, offset: 0, length: 0, hash: [n; 16] }
    }

    #[test]
    fn hashes_are_found_by_shard() {
        let store = MemStore::new();
        Blocks::write(&store, "a", &[entry(0, 1), entry(7, 2), entry(2, 3), entry(7, 1)]).unwrap();
        let blocks = Blocks::open(&store, "a").unwrap();
        let of = |shard| blocks.of(ShardId(shard)).map(|h| h[0]).collect::<Vec<_>>();
        assert_eq!([0, 1, 2, 7, 8].map(of), [vec![1], vec![], vec![3], vec![1, 2], vec![]]);
        Blocks::write(&store, "b", &[]).unwrap();
        assert_eq!(Blocks::open(&store, "b").unwrap().of(ShardId(0)).count(), 0);
    }

    #[test]
    fn a_list_that_does_not_ascend_is_refused() {
        let store = MemStore::new();
        for body in [&[1; 19][..], &[[2; 20], [1; 20]].concat()] {
            let mut out = SEAL.create(&store, "a").unwrap();
            std::io::Write::write_all(&mut out, body).unwrap();
            out.seal().unwrap();
            assert!(Blocks::open(&store, "a").unwrap_err().to_string().contains("do not ascend"));
            store.remove("a").unwrap();
        }
    }
}
