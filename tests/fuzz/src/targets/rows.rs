//! The rows of a shard and the list of a group's blocks: files as they are, or bodies under a seal that fits.

use gonio::internals::base::ids::ShardId;
use gonio::internals::disk::MemStore;
use gonio::internals::shard::{Blocks, ShardRows, rows};

use super::{BUFFERS, Target};
use crate::input;

pub const ROWS: Target = Target { name: "rows", read, may_hold: |bytes| BUFFERS + 8 * bytes };

fn read(bytes: &[u8]) -> bool {
    let Some((kind, rest)) = input::kind(bytes, 4) else { return false };
    let store = MemStore::new();
    let file = match kind {
        0 | 1 => rest.to_vec(),
        2 => input::sealed(rest, rows::VERSION, b"GONIOROW"),
        _ => input::sealed(rest, 1, b"GONIOBLK"),
    };
    input::put(&store, "any", &file);
    if kind % 2 == 0 {
        let Ok(rows) = ShardRows::read(&store, "any", ShardId(1)) else { return false };
        assert!(rows.rows.len() <= ShardId::TRIANGLES as usize);
        rows.write(&store, "again").unwrap();
        ShardRows::read(&store, "again", ShardId(1)).unwrap();
    } else {
        let Ok(blocks) = Blocks::open(&store, "any") else { return false };
        assert!((0..8).map(|shard| blocks.of(ShardId(shard)).count()).sum::<usize>() <= rest.len());
    }
    true
}
