//! Writes a cache, array after array.

use std::io::Write;
use std::path::PathBuf;

use super::{ARRAYS, LINE, SEAL, TABLE};
use crate::base::convert::to_usize;
use crate::base::{Error, Result};
use crate::disk::{FileEntry, SealedWriter, Store};
use crate::scene::Mesh;
use crate::scene::adjacency::Adjacency;
use crate::trace::hierarchy::Chunks;

/// The most memory that writing takes besides the mesh of this many triangles and vertices, bytes.
pub(crate) fn building(triangles: u64, vertices: u64) -> u64 {
    let tree = Chunks::BYTES_PER_TRIANGLE * triangles + Chunks::BYTES.min(256 * triangles);
    tree.max(Adjacency::building(triangles, vertices))
}

/// Builds the hierarchy and the neighbours of a mesh, and writes all under this name. `interrupted` is asked between
/// chunks.
///
/// # Errors
/// The file cannot be written; `Error::Interrupted` where `interrupted` says so.
pub fn write(mesh: &Mesh, store: &dyn Store, name: &str, interrupted: &dyn Fn() -> bool) -> Result<FileEntry> {
    let out = SEAL.create(store, name)?;
    let mut body = Body { out, path: store.path(name), at: 0, start: 0, lengths: Vec::new() };
    body.array(bytemuck::cast_slice(&mesh.positions))?;
    body.array(bytemuck::cast_slice(&mesh.triangles))?;
    let mut put = |bytes: &[u8]| if interrupted() { Err(Error::Interrupted) } else { body.put(bytes) };
    let ordered = Chunks::of(mesh).nodes(&mut put)?;
    body.end()?;
    ordered.triangles(&mut |bytes| body.put(bytes))?;
    body.end()?;
    let (scale, root, degenerate) = (ordered.scale(), ordered.root(), ordered.left_out());
    drop(ordered);
    if interrupted() {
        return Err(Error::Interrupted);
    }
    let adjacency = Adjacency::of(mesh);
    adjacency.arrays().into_iter().try_for_each(|array| body.array(bytemuck::cast_slice(array)))?;

    let mut table = Vec::with_capacity(TABLE);
    table.extend(body.lengths.iter().flat_map(|length| length.to_le_bytes()));
    table.extend(mesh.origin.to_array().iter().chain([&scale]).flat_map(|v| v.to_le_bytes()));
    table.extend(degenerate.to_le_bytes());
    table.extend(root.to_le_bytes());
    table.extend([0; 4]);
    debug_assert_eq!((body.lengths.len(), table.len()), (ARRAYS, TABLE));
    body.put(&table)?;
    body.out.seal()
}

/// The body of the file as far as it is written.
struct Body {
    out: SealedWriter,
    path: PathBuf,
    /// Bytes written so far.
    at: u64,
    /// Where the current array starts.
    start: u64,
    /// Bytes of each finished array.
    lengths: Vec<u64>,
}

impl Body {
    fn array(&mut self, bytes: &[u8]) -> Result<()> {
        self.put(bytes)?;
        self.end()
    }

    fn put(&mut self, bytes: &[u8]) -> Result<()> {
        self.out.write_all(bytes).map_err(Error::io("write", &self.path))?;
        self.at += bytes.len() as u64;
        Ok(())
    }

    /// Ends an array, and pads to the start of the next.
    fn end(&mut self) -> Result<()> {
        self.lengths.push(self.at - self.start);
        let pad = to_usize(self.at.next_multiple_of(LINE as u64) - self.at);
        self.put(&[0; LINE][..pad])?;
        self.start = self.at;
        Ok(())
    }
}
