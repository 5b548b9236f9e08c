//! Rays a second of one thread, over a generated height field of 500,000 triangles and, where the shared data is beside
//! the project, over `boruszyn`. Primary rays in tiles of 32 by 32 pixels, as frames are cast; the same rays one by one;
//! and rays to the sun from what they hit. `cargo bench --bench trace`.
#![expect(clippy::unwrap_used, clippy::print_stderr, reason = "a bench fails by panicking, and says what it runs on")]

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use glam::{DVec2, DVec3, Vec3};
use gonio::internals::scene::Mesh;
use gonio::internals::scene::camera::{Camera, Lens};
use gonio::internals::scene::pose::Pose;
use gonio::internals::trace::{Bvh, Hit, Ray, tile};

const TILE: u32 = 32;

/// A square of 500 by 500 cells, 1 unit each, with hills, and blocks like houses.
fn height_field() -> Mesh {
    let n = 501u32;
    let height = |x: u32, y: u32| {
        let (a, b) = (f64::from(x) * 0.05, f64::from(y) * 0.04);
        let block = f64::from((x / 12 * 7 + y / 9 * 5) % 11);
        let inside = x % 12 > 3 && y % 9 > 2;
        4.0 * a.sin() * b.cos() + if inside { block } else { 0.0 }
    };
    let vertices: Vec<DVec3> =
        (0..n * n).map(|i| DVec3::new(f64::from(i % n), f64::from(i / n), height(i % n, i / n))).collect();
    let triangles = (0..n - 1)
        .flat_map(|y| (0..n - 1).map(move |x| y * n + x))
        .flat_map(|i| [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]])
        .collect();
    Mesh::new(&vertices, triangles).unwrap()
}

/// The shared real scene, if it is there: a binary PLY of f32 vertices, then faces of a count byte and three indices.
fn boruszyn() -> Option<Mesh> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../shared/data/boruszyn/mesh.ply");
    let bytes = std::fs::read(path).ok()?;
    let (vertices, faces) = (136_310, 250_000);
    let body = &bytes[bytes.len().checked_sub(12 * vertices + 13 * faces)?..];
    let (points, lists) = body.split_at(12 * vertices);
    let word = |b: &[u8]| b.try_into().map(u32::from_le_bytes).unwrap();
    let number = |b: &[u8]| f64::from(f32::from_bits(word(b)));
    let vertices: Vec<DVec3> =
        points.chunks(12).map(|p| DVec3::new(number(&p[..4]), number(&p[4..8]), number(&p[8..]))).collect();
    let triangles = lists.chunks(13).map(|f| [word(&f[1..5]), word(&f[5..9]), word(&f[9..])]).collect();
    Mesh::new(&vertices, triangles).ok()
}

/// The rays of a frame of 1536 by 1024 pixels that looks at the mesh's centre from the south, 45 degrees down.
fn frame(mesh: &Mesh) -> (Vec3, Vec<Vec<Vec3>>) {
    let size = f64::from(mesh.positions.iter().fold(0f32, |m, p| m.max(p.abs().max_element())));
    let eye = DVec3::new(0.1, -1.2, 1.2) * size;
    let pose = Pose::look_at(eye, DVec3::ZERO, DVec3::Z);
    let lens = Lens::pinhole(DVec2::splat(1400.0), DVec2::new(768.0, 512.0));
    let camera = Camera { width: 1536, height: 1024, lens };
    let ray = |x: u32, y: u32| {
        let pixel = DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5);
        pose.to_world(camera.ray(pixel).unwrap()).as_vec3()
    };
    let order = tile::order(TILE, TILE);
    let tiles = (0..camera.height / TILE).flat_map(|y| (0..camera.width / TILE).map(move |x| (x * TILE, y * TILE)));
    (eye.as_vec3(), tiles.map(|(x, y)| order.iter().map(|at| ray(x + at.x, y + at.y)).collect()).collect())
}

fn bench(c: &mut Criterion) {
    for (name, mesh) in [("height_field", Some(height_field())), ("boruszyn", boruszyn())] {
        let Some(mesh) = mesh else { continue };
        let bvh = Bvh::build(&mesh);
        let (origin, tiles) = frame(&mesh);
        let mut hits = vec![Hit::MISS; (TILE * TILE) as usize];
        let mut shadows = Vec::new();
        for tile in &tiles {
            tile::cast(&bvh, origin, tile, &mut hits);
            for (hit, &direction) in hits.iter().zip(tile).filter(|(h, _)| h.is_some()) {
                let from = Ray { origin, direction }.at(hit.t * 0.9999);
                shadows.push(Ray { origin: from, direction: Vec3::new(0.5, -0.3, 0.7) });
            }
        }
        let rays = tiles.len() as u64 * u64::from(TILE * TILE);
        eprintln!(
            "{name}: {} triangles, {:.1} bytes each, {:.0}% of {rays} rays hit",
            mesh.len(),
            bvh.bytes() as f64 / mesh.len() as f64,
            100.0 * shadows.len() as f64 / rays as f64
        );
        let mut group = c.benchmark_group(format!("trace/{name}"));
        group.sample_size(10);
        group.throughput(Throughput::Elements(rays));
        group.bench_function("tile", |b| {
            b.iter(|| tiles.iter().for_each(|t| tile::cast(&bvh, origin, black_box(t), &mut hits)));
        });
        group.bench_function("nearest", |b| {
            b.iter(|| {
                let rays = tiles.iter().flatten().map(|&direction| Ray { origin, direction });
                rays.filter(|r| bvh.nearest(black_box(r), f32::INFINITY).is_some()).count()
            });
        });
        group.throughput(Throughput::Elements(shadows.len() as u64));
        group.bench_function("occluded", |b| {
            b.iter(|| shadows.iter().filter(|r| bvh.occluded(black_box(r), f32::INFINITY)).count());
        });
        group.throughput(Throughput::Elements(mesh.len() as u64));
        group.bench_function("build", |b| b.iter(|| Bvh::build(black_box(&mesh))));
        group.finish();
    }
}

criterion_group!(benches, bench);
criterion_main!(benches);
