//! Looks into a run: the buffers of one frame, the reflectance maps of some triangles.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use glam::DVec2;

use super::finished::{looked_at, writable};
use crate::base::ids::{ShardId, TriangleId};
use crate::base::{Error, Result};
use crate::codec::buffers::{self, Buffers};
use crate::codec::maps;
use crate::flow::pool;
use crate::phases::cast::{FrameGroups, opened_segments};
use crate::phases::light::FrozenLight;
use crate::pipeline::Pipeline;
use crate::scene::cells::Apart;
use crate::scene::reflectance::SparseMap;
use crate::scene::view::View;
use crate::shard::collect_shard;
use crate::trace::{PixelHit, TileRays};

/// Writes the buffers of one frame as a multi-channel EXR: what every pixel of its camera sees of the mesh. Reads its photograph
/// too, so that what a run said of it can be tried again.
///
/// # Errors
/// No frame of that name; anything that cannot be read or written; a photograph that a run would skip.
pub(crate) fn buffers(pipeline: &Pipeline, frame: &str, out: &Path) -> Result<()> {
    writable(pipeline, out)?;
    let (.., scene) = looked_at(pipeline)?;
    let (_, frame) = scene.frame(frame)?;
    let (mesh, bvh) = (&scene.mesh, scene.bvh());
    let size = (frame.camera.width, frame.camera.height);
    let view = View::new(frame.camera.as_ref().clone(), &frame.pose, mesh);
    let mut all = Buffers::new(size.0, size.1, mesh.origin);
    let mut rays = TileRays::default();
    for tile in view.tiles(pipeline.cast.tile) {
        for PixelHit { pixel, direction, hit } in rays.cast(&view, &bvh, tile).filter(|ray| ray.hit.is_some()) {
            let at = mesh.origin + (view.centre() + direction * hit.t).as_dvec3();
            let seen_at = frame.camera.project(frame.pose.to_camera(at)).unwrap_or(DVec2::NAN);
            let normal = mesh.normal(hit.triangle).unwrap_or_default();
            all.set(tile.position(pixel, size.0), hit.triangle, at, normal, hit.t, seen_at);
        }
    }
    buffers::write(out, all)?;
    scene.decode(pipeline).read(frame, pipeline.run.memory.0).map(drop)
}

/// Writes the reflectance maps of these triangles, as `.npz` or as one `.png`, by the name of `out`.
///
/// # Errors
/// Those of [`read_maps`]; a file that cannot be written.
pub(crate) fn maps(pipeline: &Pipeline, triangles: &[TriangleId], out: &Path) -> Result<()> {
    writable(pipeline, out)?;
    let write = maps::writer(out)?;
    write(out, &read_maps(pipeline, triangles)?)
}

/// The reflectance maps of these triangles, in their order; empty where a triangle was not seen.
///
/// # Errors
/// A triangle that the mesh does not have; frames that have not been cast yet; anything that cannot be read.
pub fn read_maps(pipeline: &Pipeline, triangles: &[TriangleId]) -> Result<Vec<SparseMap>> {
    let (store, ledger, scene) = looked_at(pipeline)?;
    if let Some(beyond) = triangles.iter().find(|t| t.index() >= scene.mesh.len()) {
        return Err(Error::invalid(format!(
            "there is no triangle {beyond}: {} has {}, counted from 0",
            pipeline.scene.mesh,
            scene.mesh.len()
        )));
    }
    let light = FrozenLight::read(&store, pipeline, scene.mesh_key)?;
    let read = || FrameGroups::read(pipeline, &store, &ledger, &scene, None, &light);
    let groups = pool::share(pipeline.run.threads(), read)??;
    let groups = groups.all();
    let missing = groups.iter().filter(|group| !ledger.is_done(&group.recipe.unit())).count();
    if missing > 0 {
        return Err(Error::invalid(format!(
            "{missing} of {} frame groups have not been cast with this configuration: `gonio run {}` comes first",
            groups.len(),
            pipeline.file.display()
        )));
    }
    let segments = opened_segments(&*store, &ledger, groups)?;
    let shards: BTreeSet<ShardId> = triangles.iter().map(|t| t.shard()).collect();
    let mut found: BTreeMap<TriangleId, SparseMap> = BTreeMap::new();
    for shard in shards {
        let maps = collect_shard(&segments, shard)?.triangles.into_iter();
        found.extend(
            maps.filter(|seen| triangles.contains(&seen.triangle))
                .map(|seen| (seen.triangle, Apart::of(seen.cells).whole)),
        );
    }
    Ok(triangles.iter().map(|t| found.get(t).cloned().unwrap_or_default()).collect())
}
