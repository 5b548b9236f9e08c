//! Maps drawn a second: the `lobe` layout, and the `sphere` layout with the camera far and near, on one thread and on all.
//! Nothing is written to the disk. `cargo bench --bench spheres`.

use std::hint::black_box;

use criterion::{Criterion, Throughput, criterion_group, criterion_main};
use gonio::internals::synth::spheres::{Camera, Layout, MAP, Sample};
use rayon::prelude::*;

/// Maps drawn a round.
const MAPS: usize = 256;

fn spheres(criterion: &mut Criterion) {
    let mut group = criterion.benchmark_group("spheres");
    group.throughput(Throughput::Elements(MAPS as u64));
    let mut maps = vec![0.0; MAPS * MAP];
    let near = Layout::Sphere(Camera::Perspective);
    for (name, layout) in
        [("lobe", Layout::Lobe), ("sphere", Layout::Sphere(Camera::Orthographic)), ("sphere from near", near)]
    {
        group.bench_function(format!("{name}, 1 thread"), |b| {
            b.iter(|| {
                for (i, map) in maps.as_chunks_mut().0.iter_mut().enumerate() {
                    Sample::draw(1, i as u64).render(layout, map);
                }
                black_box(&maps);
            });
        });
        group.bench_function(format!("{name}, {} threads", rayon::current_num_threads()), |b| {
            b.iter(|| {
                let each = maps.as_chunks_mut().0.par_iter_mut().enumerate();
                each.for_each(|(i, map)| Sample::draw(1, i as u64).render(layout, map));
                black_box(&maps);
            });
        });
    }
    group.finish();
}

criterion_group!(benches, spheres);
criterion_main!(benches);
