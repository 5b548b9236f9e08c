//! Segments as a damaged disk gives them back. Checksums would stop almost every input at the door, so all but the first
//! kind of input get good ones: the first byte says what the others are.

use std::path::Path;

use gonio::internals::base::ids::ShardId;
use gonio::internals::scene::reflectance::{Bin, BinSum};
use gonio::internals::shard::block::Columns;
use gonio::internals::shard::format::{ENTRY, Entry, MAGIC, VERSION};
use gonio::internals::shard::{Segment, collect_shard};

use super::{BUFFERS, Target};
use crate::{input, memory};

/// A block may be a thousand times smaller than what it holds; `read` compares it with what its index entry claims.
pub const SEGMENT: Target = Target { name: "segment", read: any, may_hold: |bytes| BUFFERS + (256 << 20) + 16 * bytes };

/// The most records that an entry may claim here, so that no input takes long.
const MOST: u32 = 1 << 18;

/// The most bytes that decoding holds for a record: before and after, in a vector that grows (`shard::collect`).
const RECORD: u64 = 2 * size_of::<(Bin, BinSum)>() as u64 + 72;

fn any(bytes: &[u8]) -> bool {
    let Some((kind, rest)) = input::kind(bytes, 4) else { return false };
    match kind {
        0 => read(rest),
        // An index of any entries behind any blocks.
        1 => {
            let (blocks, index) = rest.split_at(rest.len() - rest.len() / ENTRY * ENTRY);
            read(&assembled(blocks, index))
        }
        // One block: its two counts, then its bytes as they are compressed, or before they are.
        compressed => {
            let Some((counts, block)) = rest.split_first_chunk::<6>() else { return false };
            let squeezed = if compressed == 2 { zstd::encode_all(block, 1).unwrap() } else { block.to_vec() };
            let entry = Entry {
                shard: ShardId(3),
                triangles: u16::from_le_bytes([counts[0], counts[1]]).into(),
                records: u32::from_le_bytes([counts[2], counts[3], counts[4], counts[5]]),
                crc: crc32fast::hash(&squeezed),
                offset: HEADER,
                length: squeezed.len() as u64,
                hash: [0; 16],
            };
            read(&assembled(&squeezed, &entry.to_bytes()))
        }
    }
}

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
fn read(bytes: &[u8]) -> bool {
    let Ok(segment) = Segment::open(bytes, Path::new("any.seg")) else { return false };
    let mut taken = segment.index().count() == 0;
    for entry in segment.index() {
        if entry.records > MOST {
            continue;
        }
        let (block, held) = memory::most(|| segment.block(entry.shard));
        assert!(held <= BUFFERS + RECORD * u64::from(entry.records), "{held} bytes for {entry:?}");
        let Ok(Some(block)) = block else { continue };
        assert_eq!(block.records.len(), entry.records as usize);
        let twice = [(); 2].map(|()| Segment::open(bytes, Path::new("twin.seg")).unwrap());
        // Its other blocks may be damaged, but not this one.
        let maps = collect_shard(&twice, entry.shard).unwrap();
        assert_eq!(maps.triangles.len(), block.triangles.len());
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
        taken = true;
    }
    taken
}
