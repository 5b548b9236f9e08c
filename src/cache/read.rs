//! Opens a cache: maps the file and checks it from the seal to the last index.

use std::ops::Range;
use std::sync::Arc;

use glam::DVec3;

use super::{ARRAYS, Cached, LINE, SEAL, TABLE};
use crate::base::array::SharedBytes;
use crate::base::{Array, Error, Result};
use crate::disk::Store;
use crate::scene::Mesh;
use crate::scene::adjacency::Adjacency;
use crate::trace::{Bvh, Stored};

/// Opens the cache of this name. The file is read once and not held in memory.
///
/// # Errors
/// `Error::Malformed` where the file is no cache, with what is wrong.
pub fn open(store: &dyn Store, name: &str) -> Result<Cached> {
    let body = SEAL.open(store, name)?;
    parse(Arc::new(body)).map_err(|found| Error::malformed(store.path(name), found))
}

fn parse(bytes: SharedBytes) -> Result<Cached, String> {
    let body = (*bytes).as_ref();
    let (_, table) = body.split_last_chunk::<TABLE>().ok_or("it has no table")?;
    let (words, _) = table.as_chunks::<8>();
    let number = |i: usize| u64::from_le_bytes(words[i]);
    let real = |i: usize| f64::from_bits(number(i));
    let [positions, triangles, nodes, leaves, starts, neighbours] =
        ranges(std::array::from_fn(number), body.len() - TABLE)?;

    let origin = DVec3::new(real(6), real(7), real(8));
    let in_array = |name: &'static str| move |found: String| format!("{name}: {found}");
    let positions = Array::view(&bytes, positions).map_err(in_array("positions"))?;
    let triangles = Array::view(&bytes, triangles).map_err(in_array("triangles"))?;
    let mesh = Mesh::of_parts(origin, positions, triangles).map_err(|why| why.to_string())?;
    let root = number(11);
    let root = u32::try_from(root).map_err(|_| format!("hierarchy: there is no node {root}"))?;
    let stored = Stored { nodes, triangles: leaves, root, scale: real(9) };
    let bvh = Bvh::view(&bytes, &stored, mesh.len()).map_err(in_array("hierarchy"))?;
    let degenerate = number(10);
    if degenerate.checked_add(bvh.len() as u64) != Some(mesh.len() as u64) {
        return Err(format!(
            "{degenerate} triangles without area and {} in the leaves do not add up to the mesh's {}",
            bvh.len(),
            mesh.len()
        ));
    }
    let adjacency = Adjacency::view(&bytes, [starts, neighbours], mesh.len()).map_err(in_array("neighbours"))?;
    Ok(Cached { mesh, bvh, adjacency, degenerate })
}

/// The ranges of arrays of these lengths, one after the other, in `end` bytes.
fn ranges(lengths: [u64; ARRAYS], end: usize) -> Result<[Range<usize>; ARRAYS], String> {
    let mut at = 0usize;
    let mut all = [const { 0..0 }; ARRAYS];
    for (range, length) in all.iter_mut().zip(lengths) {
        let after = usize::try_from(length).ok().and_then(|n| at.checked_add(n)).filter(|&after| after <= end);
        let after =
            after.ok_or_else(|| format!("its table wants {length} bytes from {at}, but the arrays end at {end}"))?;
        *range = at..after;
        at = after.next_multiple_of(LINE);
    }
    if at != end {
        return Err(format!("its arrays end at {at}, but the table begins at {end}"));
    }
    Ok(all)
}
