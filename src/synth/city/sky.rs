//! The share of the sky that each triangle of a city sees: minutes of rays for millions of triangles. The shares are found
//! a batch of triangles at a time. Each batch becomes a sealed file of f32; when all are there, they become one file.

use std::io::Write;
use std::sync::Arc;

use crate::base::{Array, Error, Result};
use crate::disk::{Seal, Sealed, Store};
use crate::scene::Mesh;
use crate::trace::Bvh;
use crate::trace::sky_visibility;

const SEAL: Seal = Seal { magic: *b"GONIOSKY", version: 1, kind: "share of the sky" };

/// Rays a triangle.
const RAYS: u32 = 64;

/// Triangles of a batch: some seconds of rays.
const BATCH: usize = 1 << 17;

/// The shares, mapped. Shares that are not in the file of this name are found and written there.
///
/// # Errors
/// A file cannot be written; `Error::Interrupted` where `stop`, asked between batches, says so.
pub(super) fn shares(
    store: &dyn Store,
    name: &str,
    mesh: &Mesh,
    bvh: &Bvh,
    up: glam::Vec3,
    stop: &dyn Fn() -> bool,
) -> Result<Array<f32>> {
    let bytes = mesh.len() * size_of::<f32>();
    if there(store, name, mesh.len()).is_none() {
        let batch = |at: usize| (format!("{name}.{at}"), at * BATCH..mesh.len().min((at + 1) * BATCH));
        let batches: Vec<_> = (0..mesh.len().div_ceil(BATCH)).map(batch).collect();
        for (name, triangles) in &batches {
            if there(store, name, triangles.len()).is_some() {
                continue;
            }
            if stop() {
                return Err(Error::Interrupted);
            }
            write(store, name, [bytemuck::cast_slice(&sky_visibility(mesh, bvh, up, RAYS, triangles.clone()))])?;
        }
        let batches: Vec<Sealed> = batches.iter().map(|(name, _)| SEAL.open(store, name)).collect::<Result<_>>()?;
        write(store, name, batches.iter().map(|batch| &batch[..]))?;
    }
    let sealed = SEAL.open(store, name)?;
    Array::view(&(Arc::new(sealed) as _), 0..bytes).map_err(|found| Error::malformed(store.path(name), found))
}

/// The file of this name, if it is whole and has the shares of this many triangles.
fn there(store: &dyn Store, name: &str, triangles: usize) -> Option<Sealed> {
    SEAL.open(store, name).ok().filter(|sealed| sealed.len() == triangles * size_of::<f32>())
}

/// Writes the file of this name, over any other.
fn write<'a>(store: &dyn Store, name: &str, shares: impl IntoIterator<Item = &'a [u8]>) -> Result<()> {
    if store.size(name)?.is_some() {
        store.remove(name)?;
    }
    let mut out = SEAL.create(store, name)?;
    shares.into_iter().try_for_each(|bytes| out.write_all(bytes)).map_err(Error::io("write", store.path(name)))?;
    out.seal().map(drop)
}
