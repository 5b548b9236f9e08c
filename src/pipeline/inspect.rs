//! Looks into a run: the buffers of one frame, the reflectance maps of some triangles.

use std::path::Path;
use std::sync::Arc;

use glam::DVec2;

use super::exec::{segments, writable};
use super::scene::Loaded;
use super::{Pipeline, resume};
use crate::base::ids::TriangleId;
use crate::base::{Error, Result};
use crate::codec::buffers::{self, Buffers};
use crate::codec::maps;
use crate::disk::{DirStore, Manifest, Store};
use crate::scene::reflectance::SparseMap;
use crate::scene::view::View;
use crate::shard::format::SHARD;
use crate::shard::merge_shard;
use crate::trace::TileRays;

/// Writes the buffers of one frame as a multi-channel EXR: what every pixel of its camera sees of the mesh.
///
/// # Errors
/// No frame of that name; anything that cannot be read or written.
pub fn buffers(pipeline: &Pipeline, frame: &str, out: &Path) -> Result<()> {
    writable(out)?;
    let loaded = Loaded::read(pipeline)?;
    let (_, frame) = loaded.frame(frame)?;
    let (mesh, bvh) = (&loaded.mesh, loaded.bvh());
    let size = (frame.camera.width, frame.camera.height);
    let view = View::new(frame.camera.as_ref().clone(), &frame.pose, mesh);
    let mut all = Buffers::new(size.0, size.1, mesh.origin);
    let mut rays = TileRays::default();
    for tile in view.tiles(pipeline.cast.tile) {
        for (pixel, direction, hit) in rays.cast(&view, &bvh, tile).filter(|(.., hit)| hit.is_some()) {
            let at = mesh.origin + (view.centre() + direction * hit.t).as_dvec3();
            let seen_at = frame.camera.project(frame.pose.to_camera(at)).unwrap_or(DVec2::NAN);
            let normal = mesh.normal(hit.triangle).unwrap_or_default();
            all.set(tile.position(pixel, size.0), hit.triangle, at, normal, hit.t, seen_at);
        }
    }
    buffers::write(out, all)
}

/// Writes the reflectance maps of these triangles, as `.npz` or as one `.png`, by the name of `out`.
///
/// # Errors
/// A triangle that the mesh does not have; no finished segments; anything that cannot be read or written.
pub fn maps(pipeline: &Pipeline, triangles: &[TriangleId], out: &Path) -> Result<()> {
    writable(out)?;
    let write = maps::writer(out)?;
    let loaded = Loaded::read(pipeline)?;
    if let Some(beyond) = triangles.iter().find(|&&t| t as usize >= loaded.mesh.len()) {
        return Err(Error::invalid(format!(
            "there is no triangle {beyond}: {} has {}, counted from 0",
            pipeline.scene.mesh.display(),
            loaded.mesh.len()
        )));
    }
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&pipeline.run.work));
    let manifest = Manifest::read(Arc::clone(&store))?;
    let groups = resume::groups(pipeline, &manifest, loaded.mesh_key, &loaded.frames, None);
    let missing = resume::to_do(&manifest, &groups).len();
    if missing > 0 {
        return Err(Error::invalid(format!(
            "{missing} of {} frame groups have not been cast with this configuration: `gonio run {}` comes first",
            groups.len(),
            pipeline.file.display()
        )));
    }
    let segments = segments(&*store, &manifest, &groups)?;
    let mut shards: Vec<u32> = triangles.iter().map(|t| t / SHARD).collect();
    shards.sort_unstable();
    shards.dedup();
    let mut found: Vec<(TriangleId, SparseMap)> = Vec::new();
    for shard in shards {
        let maps = merge_shard(&segments, shard)?.triangles.into_iter();
        found.extend(maps.filter(|(t, ..)| triangles.contains(t)).map(|(t, _, map)| (t, map)));
    }
    let asked: Vec<SparseMap> = triangles
        .iter()
        .map(|t| found.binary_search_by_key(t, |f| f.0).map(|i| found[i].1.clone()).unwrap_or_default())
        .collect();
    write(out, &asked)
}
