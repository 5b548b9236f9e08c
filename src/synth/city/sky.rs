//! The share of the sky that each triangle of a city sees: minutes of rays where triangles are millions. It is found some
//! triangles at a time, each part a sealed file of f32 that is kept until the city is done, and then one of all parts.

use std::io::Write;
use std::sync::Arc;

use crate::base::ids::TriangleId;
use crate::base::{Array, Error, Result};
use crate::disk::{Seal, Sealed, Store};
use crate::render::sky_visibility;
use crate::scene::Mesh;
use crate::trace::Bvh;

const SEAL: Seal = Seal { magic: *b"GONIOSKY", version: 1, kind: "share of the sky" };

/// Rays a triangle.
const RAYS: u32 = 64;

/// Triangles of a part: some seconds of rays.
const PART: usize = 1 << 17;

/// The shares, mapped; found and written under `folder`, which ends in `/`, as far as they are not there.
///
/// # Errors
/// Anything that cannot be written; `Error::Interrupted` where `stop`, asked between the parts, says so.
pub fn shares(
    store: &dyn Store,
    folder: &str,
    mesh: &Mesh,
    bvh: &Bvh,
    up: glam::Vec3,
    stop: &dyn Fn() -> bool,
) -> Result<Array<f32>> {
    let name = format!("{folder}sky");
    let bytes = mesh.len() * size_of::<f32>();
    if there(store, &name, mesh.len()).is_none() {
        let part = |at: usize| (format!("{name}.{at}"), at * PART..mesh.len().min((at + 1) * PART));
        let parts: Vec<_> = (0..mesh.len().div_ceil(PART)).map(part).collect();
        for (name, triangles) in &parts {
            if there(store, name, triangles.len()).is_some() {
                continue;
            }
            if stop() {
                return Err(Error::Interrupted);
            }
            let ids = triangles.start as TriangleId..triangles.end as TriangleId;
            write(store, name, [bytemuck::cast_slice(&sky_visibility(mesh, bvh, up, RAYS, ids))])?;
        }
        let parts: Vec<Sealed> = parts.iter().map(|(name, _)| SEAL.open(store, name)).collect::<Result<_>>()?;
        write(store, &name, parts.iter().map(|part| &part[..]))?;
    }
    let sealed = SEAL.open(store, &name)?;
    Array::view(&(Arc::new(sealed) as _), 0..bytes).map_err(|found| Error::malformed(store.path(&name), found))
}

/// The file of this name, if it is a good one of so many triangles; another is removed when it is replaced.
fn there(store: &dyn Store, name: &str, triangles: usize) -> Option<Sealed> {
    SEAL.open(store, name).ok().filter(|sealed| sealed.len() == triangles * size_of::<f32>())
}

fn write<'a>(store: &dyn Store, name: &str, parts: impl IntoIterator<Item = &'a [u8]>) -> Result<()> {
    if store.size(name)?.is_some() {
        store.remove(name)?;
    }
    let mut out = SEAL.create(store, name)?;
    parts.into_iter().try_for_each(|bytes| out.write_all(bytes)).map_err(Error::io("write", store.path(name)))?;
    out.seal().map(drop)
}
