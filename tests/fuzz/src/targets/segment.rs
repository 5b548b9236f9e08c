//! Segments as a damaged disk gives them back. Checksums would stop almost every input at the door, so all but the first
//! kind of input get good ones: the first byte says what the others are.
#![no_main]

use std::path::Path;

use gonio::internals::base::ids::ShardId;
use gonio::internals::shard::block::Columns;
use gonio::internals::shard::format::{ENTRY, Entry, MAGIC, VERSION};
use gonio::internals::shard::{Segment, collect_shard};
use libfuzzer_sys::fuzz_target;

fuzz_target!(|bytes: &[u8]| {
    let Some((kind, rest)) = bytes.split_first() else { return };
    match kind % 4 {
        0 => read(rest),
        // An index of any entries behind any blocks.
        1 => {
            let (blocks, index) = rest.split_at(rest.len() - rest.len() / ENTRY * ENTRY);
            read(&assembled(blocks, index));
        }
        // One block: its two counts, then its bytes as they are compressed, or before they are.
        compressed => {
            let Some((counts, block)) = rest.split_first_chunk::<4>() else { return };
            let squeezed = if compressed == 2 { zstd::encode_all(block, 1).unwrap() } else { block.to_vec() };
            let entry = Entry {
                shard: ShardId(3),
                triangles: u16::from_le_bytes([counts[0], counts[1]]).into(),
                records: u16::from_le_bytes([counts[2], counts[3]]).into(),
                crc: crc32fast::hash(&squeezed),
                offset: HEADER,
                length: squeezed.len() as u64,
                hash: [0; 16],
            };
            read(&assembled(&squeezed, &entry.to_bytes()));
        }
    }
});

const HEADER: u64 = 12;

/// Blocks and index with all that stands around them.
fn assembled(blocks: &[u8], index: &[u8]) -> Vec<u8> {
    let mut all = [&MAGIC[..], &VERSION.to_le_bytes(), blocks, index].concat();
    all.extend((HEADER + blocks.len() as u64).to_le_bytes());
    all.extend(((index.len() / ENTRY) as u32).to_le_bytes());
    all.extend(crc32fast::hash(index).to_le_bytes());
    all.extend(MAGIC);
    all
}

/// What can be read can be merged, and written and read again.
fn read(bytes: &[u8]) {
    let Ok(segment) = Segment::open(bytes, Path::new("any.seg")) else { return };
    for entry in segment.index() {
        let Ok(Some(block)) = segment.block(entry.shard) else { continue };
        assert_eq!(block.records.len(), entry.records as usize);
        collect_shard(&[Segment::open(bytes, Path::new("twin.seg")).unwrap()], entry.shard).unwrap();
        let (mut columns, mut raw, mut left) = (Columns::default(), Vec::new(), block.records.as_slice());
        columns.begin(entry.shard);
        for seen in &block.triangles {
            let (own, rest) = left.split_at(seen.records as usize);
            columns.push(seen.triangle, seen.frames, own);
            left = rest;
        }
        columns.write(&mut raw);
        let again = zstd::encode_all(&raw[..], 1).unwrap();
        let again = gonio::internals::shard::block::decode(&again, entry.shard, entry.triangles, entry.records);
        assert_eq!(again.as_ref(), Ok(&block));
    }
}
