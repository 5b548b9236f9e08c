use glam::{DVec3, Vec3};
use tempfile::TempDir;

use super::*;
use crate::base::Error;
use crate::base::ids::TriangleId;
use crate::disk::{DirStore, Store};
use crate::trace::Ray;

/// A hilly square of `2 n^2` triangles, and one without area.
fn hills(n: u32) -> Mesh {
    let height = |i: u32| f64::from(i * i % 97) / 50.0;
    let place = |i: u32| DVec3::new(5e5 + f64::from(i % (n + 1)), f64::from(i / (n + 1)), height(i));
    let vertices: Vec<DVec3> = (0..(n + 1) * (n + 1)).map(place).collect();
    let cells = (0..n * n).map(|i| i / n * (n + 1) + i % n);
    let mut triangles: Vec<[u32; 3]> =
        cells.flat_map(|i| [[i, i + 1, i + n + 1], [i + 1, i + n + 2, i + n + 1]]).collect();
    triangles.push([0, 0, 1]);
    Mesh::new(&vertices, triangles).unwrap()
}

fn store() -> (TempDir, DirStore) {
    let dir = TempDir::new().unwrap();
    let store = DirStore::new(dir.path());
    (dir, store)
}

/// The bytes of the file that `mesh` becomes.
fn written(mesh: &Mesh) -> Vec<u8> {
    let (_dir, store) = store();
    write(mesh, &store, "whole", &|| false).unwrap();
    store.open("whole").unwrap().to_vec()
}

/// The error from opening a file with these bytes.
fn refusal(store: &DirStore, bytes: &[u8]) -> Option<String> {
    std::fs::write(store.path("torn"), bytes).unwrap();
    match open(store, "torn") {
        Ok(_) => None,
        Err(Error::Malformed { path, found }) if path.ends_with("torn") => Some(found),
        Err(other) => panic!("{other}"),
    }
}

/// The error from a mangled body under a seal that fits.
fn resealed(store: &DirStore, file: &[u8], mangle: impl FnOnce(&mut Vec<u8>)) -> Option<String> {
    let mut body = file[..file.len() - 24].to_vec();
    mangle(&mut body);
    let mut bytes = body.clone();
    bytes.extend((body.len() as u64).to_le_bytes());
    bytes.extend(VERSION.to_le_bytes());
    bytes.extend(crc32fast::hash(&body).to_le_bytes());
    bytes.extend(SEAL.magic);
    refusal(store, &bytes)
}

#[test]
fn what_comes_back_is_what_would_be_built() {
    let (_dir, store) = store();
    let mesh = hills(40);
    write(&mesh, &store, "a", &|| false).unwrap();
    let cached = open(&store, "a").unwrap();
    assert_eq!(cached.mesh, mesh);
    assert_eq!(cached.adjacency, Adjacency::of(&mesh));
    assert_eq!((cached.degenerate, cached.bvh.len()), (1, 3200));
    assert_eq!((cached.mesh.held(), cached.bvh.held()), (0, 0), "it is mapped");
    let built = Bvh::build(&mesh);
    for i in 0..500 {
        let origin = Vec3::new((i % 40) as f32 - 20.0, (i / 13) as f32 - 20.0, 9.0);
        let ray = Ray { origin, direction: Vec3::new(0.1, 0.02 * (i % 7) as f32, -1.0) };
        assert_eq!(cached.bvh.nearest(&ray, f32::INFINITY), built.nearest(&ray, f32::INFINITY));
    }
    // A function of the mesh alone.
    assert_eq!(written(&mesh), store.open("a").unwrap().to_vec());
}

#[test]
fn an_interrupted_one_leaves_nothing() {
    let (_dir, store) = store();
    assert!(write(&hills(4), &store, "a", &|| true).unwrap_err().is_interrupt());
    assert!(store.list("").unwrap().is_empty() && store.sweep().unwrap().is_empty());
}

#[test]
fn every_cut_and_every_flip_is_refused() {
    let (_dir, store) = store();
    let whole = written(&hills(3));
    assert_eq!(refusal(&store, &whole), None);
    for cut in 0..whole.len() {
        assert!(refusal(&store, &whole[..cut]).is_some(), "cut at {cut}");
    }
    for at in 0..whole.len() {
        let mut flipped = whole.clone();
        flipped[at] ^= 1 << (at % 8);
        assert!(refusal(&store, &flipped).is_some(), "byte {at}");
    }
}

#[test]
fn what_a_good_seal_covers_is_not_trusted_either() {
    let (_dir, store) = store();
    let mesh = hills(3);
    let whole = written(&mesh);
    assert_eq!(resealed(&store, &whole, |_| {}), None);
    let table = whole.len() - 24 - TABLE;
    let put = |at: usize, bytes: &'static [u8]| {
        resealed(&store, &whole, move |body| body[at..at + bytes.len()].copy_from_slice(bytes)).unwrap_or_default()
    };
    let (triangles, nodes) = (mesh.positions.len() * 12, mesh.len() * 12);
    let triangles = triangles.next_multiple_of(LINE);
    let nodes = (triangles + nodes).next_multiple_of(LINE);
    for (at, bytes, words) in [
        (0, &f32::NAN.to_le_bytes()[..].to_vec(), "vertex 0"),
        (triangles, &u32::MAX.to_le_bytes().to_vec(), "face 0 refers to vertex 4294967295"),
        (nodes + 96, &u32::MAX.to_le_bytes().to_vec(), "hierarchy: "),
        (nodes + 112, &vec![0, 0, 0, 0], "hierarchy: "),
        (table, &u64::MAX.to_le_bytes().to_vec(), "its table wants"),
        (table, &12u64.to_le_bytes().to_vec(), "its arrays end"),
        (table + 48, &f64::INFINITY.to_le_bytes().to_vec(), "vertex"),
        (table + 72, &3f64.to_le_bytes().to_vec(), "not a power of two"),
        (table + 80, &u64::MAX.to_le_bytes().to_vec(), "without area"),
        (table + 88, &999u32.to_le_bytes().to_vec(), "it wants node 999"),
        (table + 92, &1u32.to_le_bytes().to_vec(), "there is no node"),
        (table - 128, &u32::MAX.to_le_bytes().to_vec(), "neighbour"),
    ] {
        let found = put(at, bytes.clone().leak());
        assert!(found.contains(words), "{at} {bytes:?}: {found:?}");
    }
    assert!(resealed(&store, &whole, Vec::clear).unwrap().contains("no table"));
    assert!(resealed(&store, &whole, |body| body.truncate(body.len() - 1)).is_some());
}

#[test]
fn any_word_of_a_table_or_an_array_may_be_anything() {
    let (_dir, store) = store();
    let whole = written(&hills(3));
    let directions = [Vec3::NEG_Z, Vec3::X, Vec3::new(0.3, 0.2, -1.0)];
    for at in (0..whole.len() - 24).step_by(4) {
        for word in [0u32, 1, 64, 0x7fff_ffff, 0x7fc0_0000, u32::MAX] {
            let said = resealed(&store, &whole, |body| {
                if let Some(there) = body.get_mut(at..at + 4) {
                    there.copy_from_slice(&word.to_le_bytes());
                }
            });
            if said.is_none() {
                // It is believed: then nothing that it is used for panics or goes on for ever.
                let cached = open(&store, "torn").unwrap();
                for t in TriangleId::all(cached.mesh.len()) {
                    cached
                        .adjacency
                        .neighbours(t)
                        .iter()
                        .for_each(|&n| assert!(cached.mesh.normal(n).is_none_or(|v| v.is_finite())));
                }
                for direction in directions {
                    let ray = Ray { origin: Vec3::Z * 5.0, direction };
                    if let Some(hit) = cached.bvh.nearest(&ray, f32::INFINITY) {
                        assert!(hit.triangle.index() < cached.mesh.len());
                    }
                }
            }
        }
    }
}
