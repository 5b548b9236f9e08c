//! The layout of a segment file, version 3. Integers are little endian; `varint` is LEB128.
//!
//! ```text
//! magic     8 bytes  "GONIOSEG"
//! version   u32
//! block     one per shard that holds anything, ascending by shard:
//!           zstd of six columns, each a varint byte length and then its bytes
//!             triangles   per triangle: varint delta to the one before (the first: to the shard's first triangle),
//!                         varint frames that saw it, varint records - 1
//!             bins        per record: varint delta to the bin before in the same triangle (the first: the bin)
//!             counts      per record: varint (count - 1) << 1 | (clipped != 0), then varint clipped if it is not 0
//!             red, green, blue
//!                         per record: q = sum / count as a zigzag varint of its difference, red and blue to the same
//!                         record's green, green to the record's before; then, if count > 1, varint sum % count
//! index     one entry a block: shard u32, triangles u32, records u32, crc32 u32 of the compressed bytes,
//!           offset u64, length u64, hash 16 bytes: the first of the BLAKE3 of the block's columns, not compressed
//! footer    index offset u64, entries u32, crc32 u32 of the index, magic 8 bytes
//! ```
//!
//! Quotients lie close together and remainders are short; zstd alone cannot find that in raw sums.
//! Equal hashes mean equal records, so that a shard whose hashes have not changed is not inferred again.
//! A reader verifies magic, version, footer, that the file ends where the footer says, the index's checksum, and each
//! block's checksum before it is decoded.

use crate::base::ids::ShardId;

/// First and last bytes of a segment.
pub const MAGIC: [u8; 8] = *b"GONIOSEG";
/// Version of the layout above; part of every unit key.
pub const VERSION: u32 = 3;
/// Bytes of magic and version.
pub(crate) const HEADER: usize = 12;
/// Bytes of an index entry.
pub const ENTRY: usize = 48;
/// Bytes of the footer.
pub(crate) const FOOTER: usize = 24;

/// An entry of the index: where a shard's block lies.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Entry {
    /// The block's shard.
    pub shard: ShardId,
    /// Triangles in the block.
    pub triangles: u32,
    /// Records in the block.
    pub records: u32,
    /// crc32 of the compressed block.
    pub crc: u32,
    /// Where the block starts in the file.
    pub offset: u64,
    /// Bytes of the compressed block.
    pub length: u64,
    /// The block's content hash.
    pub hash: Hash,
}

/// The content hash of a block.
pub(crate) type Hash = [u8; 16];

impl Entry {
    /// The entry's bytes in the file.
    pub fn to_bytes(self) -> [u8; ENTRY] {
        let mut out = [0; ENTRY];
        for (i, v) in [self.shard.0, self.triangles, self.records, self.crc].into_iter().enumerate() {
            out[4 * i..4 * i + 4].copy_from_slice(&v.to_le_bytes());
        }
        out[16..24].copy_from_slice(&self.offset.to_le_bytes());
        out[24..32].copy_from_slice(&self.length.to_le_bytes());
        out[32..].copy_from_slice(&self.hash);
        out
    }

    /// An entry from its bytes.
    pub fn from_bytes(b: &[u8; ENTRY]) -> Entry {
        let word = |i: usize| u32_at(b, 4 * i);
        let mut hash = Hash::default();
        hash.copy_from_slice(&b[32..]);
        Entry {
            shard: ShardId(word(0)),
            triangles: word(1),
            records: word(2),
            crc: word(3),
            offset: u64_at(b, 16),
            length: u64_at(b, 24),
            hash,
        }
    }
}

/// Little-endian u32 at `at`, which must lie within `bytes`.
pub(crate) fn u32_at(bytes: &[u8], at: usize) -> u32 {
    let mut word = [0; 4];
    word.copy_from_slice(&bytes[at..at + 4]);
    u32::from_le_bytes(word)
}

/// Little-endian u64 at `at`, which must lie within `bytes`.
pub(crate) fn u64_at(bytes: &[u8], at: usize) -> u64 {
    u64::from(u32_at(bytes, at)) | u64::from(u32_at(bytes, at + 4)) << 32
}
