//! Maps a second that are drawn: the `lobe` and the `sphere` kind, its camera afar and near, on one thread and on all.
//! What the disk takes of them is its own affair. `cargo bench --bench spheres`.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gonio::synth::spheres::{Camera, MAP, Picture, Sample};
use rayon::prelude::*;

/// Maps a round.
const MAPS: usize = 256;

fn spheres(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("spheres");
    group.throughput(Throughput::Elements(MAPS as u64));
    let mut maps = vec![0.0; MAPS * MAP];
    let near = Picture::Sphere(Camera::Perspective);
    for (kind, picture) in
        [("lobe", Picture::Lobe), ("sphere", Picture::Sphere(Camera::Orthographic)), ("sphere from near", near)]
    {
        group.bench_function(format!("{kind}, 1 thread"), |b| {
            b.iter(|| {
                for (i, map) in maps.as_chunks_mut().0.iter_mut().enumerate() {
                    Sample::draw(1, i as u64).render(picture, map);
                }
                black_box(&maps);
            });
        });
        group.bench_function(format!("{kind}, {} threads", rayon::current_num_threads()), |b| {
            b.iter(|| {
                let each = maps.as_chunks_mut().0.par_iter_mut().enumerate();
                each.for_each(|(i, map)| Sample::draw(1, i as u64).render(picture, map));
                black_box(&maps);
            });
        });
    }
    group.finish();
}

criterion_group!(benches, spheres);
criterion_main!(benches);
