//! Writes a cache, array after array.

use std::io::Write;
use std::path::PathBuf;

use super::{ARRAYS, LINE, SEAL, TABLE};
use crate::base::{Error, Result};
use crate::disk::{FileEntry, SealedWriter, Store};
use crate::scene::Mesh;
use crate::scene::adjacency::Adjacency;
use crate::trace::build::Parts;

/// Bytes of memory that writing takes besides the mesh, for this many triangles and vertices, at most.
pub fn building(triangles: u64, vertices: u64) -> u64 {
    let tree = Parts::BYTES_PER_TRIANGLE * triangles + Parts::BYTES.min(256 * triangles);
    tree.max(Adjacency::building(triangles, vertices))
}

/// Makes what a mesh is cast with and writes it all under this name. `interrupted` is asked between the parts.
///
/// # Errors
/// Anything that cannot be written; `Error::Interrupted` if so asked.
pub fn write(mesh: &Mesh, store: &dyn Store, name: &str, interrupted: &dyn Fn() -> bool) -> Result<FileEntry> {
    let out = SEAL.create(store, name)?;
    let mut body = Body { out, path: store.path(name), at: 0, start: 0, lengths: Vec::new() };
    body.array(bytemuck::cast_slice(&mesh.positions))?;
    body.array(bytemuck::cast_slice(&mesh.triangles))?;
    let mut put = |bytes: &[u8]| if interrupted() { Err(Error::Interrupted) } else { body.put(bytes) };
    let ordered = Parts::of(mesh).nodes(&mut put)?;
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

/// The body of the file, as far as it has come.
struct Body {
    out: SealedWriter,
    path: PathBuf,
    at: u64,
    /// Where the array that is being written starts.
    start: u64,
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

    /// Ends an array: the next begins on a line of its own.
    fn end(&mut self) -> Result<()> {
        self.lengths.push(self.at - self.start);
        let pad = (self.at.next_multiple_of(LINE as u64) - self.at) as usize;
        self.put(&[0; LINE][..pad])?;
        self.start = self.at;
        Ok(())
    }
}
