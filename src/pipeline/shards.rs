//! The shards of a run and their keys: what has to be inferred again when a few frames have changed.

use super::Pipeline;
use crate::base::key::{Key, KeyBuilder};
use crate::shard::format::Hash;
use crate::shard::{Blocks, format, rows};
use crate::stages::merge;
use crate::stages::shards::Shard;

/// The shards below `count` that something was observed in. `made` is the key of what turns their blocks into rows.
pub fn shards(blocks: &[Blocks], count: u32, made: Key) -> Vec<Shard> {
    let shard = |number: u32| {
        let mut hashes: Vec<Hash> = blocks.iter().flat_map(|unit| unit.of(number)).collect();
        // Which unit a block belongs to has no part in what comes of it.
        hashes.sort_unstable();
        let start = KeyBuilder::new("gonio shard unit 1").key(made).field(&number.to_le_bytes());
        let key = hashes.iter().fold(start, |key, hash| key.field(hash)).finish();
        (!hashes.is_empty()).then_some(Shard { number, key })
    };
    (0..count).filter_map(shard).collect()
}

/// The key of what turns blocks into rows: the network and its engine, settings and formats.
pub fn made(pipeline: &Pipeline, estimator: Key) -> Key {
    KeyBuilder::new("gonio infer 1")
        .key(estimator)
        .field(&pipeline.merge.min_bins.to_le_bytes())
        .field(&format::VERSION.to_le_bytes())
        .field(&rows::VERSION.to_le_bytes())
        .finish()
}

/// The key of the tables that are made of these shards.
pub fn tables(pipeline: &Pipeline, mesh: Key, shards: &[Shard]) -> Key {
    let start = KeyBuilder::new("gonio tables unit 1")
        .key(mesh)
        .field(&[u8::from(pipeline.merge.fill)])
        .field(&merge::VERSION.to_le_bytes());
    shards.iter().fold(start, |key, shard| key.key(shard.key)).finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::MemStore;
    use crate::shard::format::Entry;

    /// Units whose blocks are given as `(shard, content)`.
    fn keys(units: &[&[(u32, u8)]], made: u8) -> Vec<Shard> {
        let store = MemStore::new();
        let entry = |&(shard, n): &(u32, u8)| Entry {
            shard,
            triangles: 1,
            records: 1,
            crc: 0,
            offset: 0,
            length: 0,
            hash: [n; 16],
        };
        let open = |(at, unit): (usize, &&[(u32, u8)])| {
            let name = at.to_string();
            Blocks::write(&store, &name, &unit.iter().map(entry).collect::<Vec<_>>()).unwrap();
            Blocks::open(&store, &name).unwrap()
        };
        shards(&units.iter().enumerate().map(open).collect::<Vec<_>>(), 9, Key([made; 32]))
    }

    #[test]
    fn a_shard_changes_with_its_blocks_and_with_nothing_else() {
        let before = keys(&[&[(0, 1), (2, 1)], &[(2, 7), (3, 1), (9, 1)]], 0);
        assert_eq!(before.iter().map(|s| s.number).collect::<Vec<_>>(), [0, 2, 3]);
        assert_ne!(before[0].key, before[2].key, "equal blocks of other shards");
        for (units, made, changed, why) in [
            (&[&[(2, 7), (3, 1)][..], &[(0, 1), (2, 1)]], 0, [false; 3], "units in another order"),
            (&[&[(0, 1), (2, 1), (2, 7)], &[(3, 1)]], 0, [false; 3], "blocks in other units"),
            (&[&[(0, 1), (2, 1)], &[(2, 8), (3, 1)]], 0, [false, true, false], "another block"),
            (&[&[(0, 1), (2, 1)], &[(2, 7), (2, 7), (3, 1)]], 0, [false, true, false], "a block more"),
            (&[&[(0, 1), (2, 1)], &[(3, 1), (2, 7)]], 1, [true; 3], "another model"),
        ] {
            let after = keys(units, made);
            let found: Vec<bool> = before.iter().zip(&after).map(|(a, b)| a != b).collect();
            assert_eq!(found, changed, "{why}");
        }
    }
}
