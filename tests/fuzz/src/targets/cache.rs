//! The scene cache: a file as it is, or a body under a seal that fits. What is opened can be cast into.

use glam::Vec3;
use gonio::TriangleId;
use gonio::internals::cache;
use gonio::internals::disk::MemStore;
use gonio::internals::trace::{Hit, Ray, tile};

use super::{BUFFERS, Target};
use crate::input;

/// Arrays that do not lie on whole values are copied.
pub const CACHE: Target = Target { name: "cache", read, may_hold: |bytes| BUFFERS + 8 * bytes };

pub const MAGIC: &[u8; 8] = b"GONIOSCN";

fn read(bytes: &[u8]) -> bool {
    let Some((kind, rest)) = input::kind(bytes, 2) else { return false };
    let store = MemStore::new();
    let file = if kind == 0 { rest.to_vec() } else { input::sealed(rest, cache::VERSION, MAGIC) };
    input::put(&store, "any", &file);
    let Ok(scene) = cache::open(&store, "any") else { return false };
    let all = scene.mesh.len();
    for triangle in (0..all.min(64) as u32).map(TriangleId) {
        scene.mesh.corners(triangle);
        scene.mesh.normal(triangle);
        assert!(scene.adjacency.neighbours(triangle).iter().all(|other| other.index() < all));
    }
    let directions: Vec<Vec3> = (0..40).map(|i| Vec3::new((i as f32).sin(), (i as f32 * 0.7).cos(), -0.5)).collect();
    for origin in [Vec3::ZERO, Vec3::new(0.1, 0.2, 10.0), Vec3::splat(-3.0)] {
        let mut hits = vec![Hit::MISS; directions.len()];
        tile::cast(&scene.bvh, origin, &directions, &mut hits);
        for (hit, &direction) in hits.iter().zip(&directions) {
            assert!(!hit.is_some() || hit.triangle.index() < all);
            scene.bvh.occluded(&Ray { origin, direction }, f32::INFINITY);
        }
    }
    true
}
