//! Opens a segment: verifies header, footer and index at once, and each block when it is read.

use std::ops::Range;
use std::path::{Path, PathBuf};

use super::block::{self, Block};
use super::format::{ENTRY, Entry, FOOTER, HEADER, MAGIC, VERSION, u32_at, u64_at};
use crate::base::convert::to_usize;
use crate::base::ids::ShardId;
use crate::base::{Error, Result};
use crate::scene::cells::CELLS;

/// An open segment over its bytes, mapped or in memory.
#[derive(Debug)]
pub struct Segment<B> {
    bytes: B,
    path: PathBuf,
    /// Where the index lies. It is read in place: a run may have thousands of segments open.
    index: Range<usize>,
}

impl<B: AsRef<[u8]>> Segment<B> {
    /// Opens a segment once magic, version, footer and index are checked. Errors name `path`.
    pub fn open(bytes: B, path: &Path) -> Result<Self> {
        let index = find_index(bytes.as_ref()).map_err(|found| Error::malformed(path, found))?;
        Ok(Segment { bytes, path: path.to_owned(), index })
    }

    fn entries(&self) -> &[[u8; ENTRY]] {
        self.bytes.as_ref()[self.index.clone()].as_chunks().0
    }

    /// The index entries of the blocks, ascending by shard.
    pub fn index(&self) -> impl Iterator<Item = Entry> {
        self.entries().iter().map(Entry::from_bytes)
    }

    /// The index entry of a shard; `None` if the segment has no block of it.
    pub fn entry(&self, shard: ShardId) -> Option<Entry> {
        let entries = self.entries();
        let found = entries.binary_search_by_key(&shard, |e| Entry::from_bytes(e).shard).ok();
        found.map(|at| Entry::from_bytes(&entries[at]))
    }

    /// A shard's block, verified; `None` if the segment has none.
    pub fn block(&self, shard: ShardId) -> Result<Option<Block>> {
        let Some(e) = self.entry(shard) else { return Ok(None) };
        let bytes = &self.bytes.as_ref()[to_usize(e.offset)..to_usize(e.offset + e.length)];
        let fault = |found: String| Error::malformed(&self.path, found);
        if crc32fast::hash(bytes) != e.crc {
            return Err(fault(format!(
                "block of shard {shard} (bytes {} to {}) fails its checksum",
                e.offset,
                e.offset + e.length
            )));
        }
        block::decode(bytes, shard, e.triangles, e.records).map(Some).map_err(fault)
    }

    /// Reads and verifies every block.
    pub fn verify(&self) -> Result<()> {
        self.index().try_for_each(|e| self.block(e.shard).map(drop))
    }
}

/// Checks the index and says where it lies.
fn find_index(bytes: &[u8]) -> Result<Range<usize>, String> {
    let short = || format!("{} bytes are too few for a segment: the file was cut short", bytes.len());
    let body = bytes.len().checked_sub(FOOTER).filter(|&n| n >= HEADER).ok_or_else(short)?;
    if bytes[..8] != MAGIC {
        return Err("not a segment: it does not begin with GONIOSEG".into());
    }
    let version = u32_at(bytes, 8);
    if version != VERSION {
        return Err(format!("segment version {version}; this gonio reads version {VERSION}"));
    }
    if bytes[bytes.len() - 8..] != MAGIC {
        return Err("the footer is missing: the segment was cut short".into());
    }
    let (start, entries) = (u64_at(bytes, body), u32_at(bytes, body + 8) as usize);
    let index = usize::try_from(start)
        .ok()
        .filter(|&s| s >= HEADER && s.checked_add(entries.saturating_mul(ENTRY)) == Some(body))
        .map(|s| s..body)
        .ok_or("the footer does not fit the file's length")?;
    if crc32fast::hash(&bytes[index.clone()]) != u32_at(bytes, body + 12) {
        return Err("the index fails its checksum".into());
    }
    let mut end = HEADER as u64;
    let mut before = None;
    for e in bytes[index.clone()].as_chunks().0.iter().map(Entry::from_bytes) {
        let inside = e.offset == end && e.length <= start && e.offset + e.length <= start;
        let most = u64::from(e.triangles) * CELLS as u64;
        let counted = e.triangles >= 1
            && e.triangles <= ShardId::TRIANGLES
            && e.records >= e.triangles
            && u64::from(e.records) <= most;
        if !inside || !counted || before >= Some(e.shard) || e.shard > ShardId::LAST {
            return Err(format!("the index entry of shard {} does not fit the file", e.shard));
        }
        (end, before) = (e.offset + e.length, Some(e.shard));
    }
    if end != start {
        return Err("the blocks do not end where the index begins".into());
    }
    Ok(index)
}
