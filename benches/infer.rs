//! Maps a second: the network on each engine, and the fit, on one thread and on two. One element is one map.
//!
//! `ORT_DYLIB_PATH` names an ONNX Runtime library; without one, only the built-in engine runs. `GONIO_MODEL` names another model
//! than the built-in one. `GONIO_BINS` is the number of bins that a map fills, 16 if unset, the median of real scenes.
#![expect(clippy::expect_used, reason = "a benchmark that cannot start should stop")]

use std::path::Path;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use glam::Vec3;
use gonio::internals::model::{self, Backend, Estimate, Estimator, Fit, ModelSource};
use gonio::internals::scene::light::LocalLight;
use gonio::internals::scene::reflectance::{Bin, BinSum, FRONT_BINS, SparseMap};

const MAPS: usize = 512;

fn infer(criterion: &mut Criterion) {
    let name = std::env::var("GONIO_MODEL").unwrap_or_else(|_| model::BUILT_IN[0].name.into());
    let source = ModelSource::named(&name, Path::new(""));
    let filled = std::env::var("GONIO_BINS").map_or(16, |n| n.parse().expect("a number of bins"));
    let library = std::env::var_os("ORT_DYLIB_PATH").is_some_and(|v| !v.is_empty());
    let backends = if library { &[Backend::Embedded, Backend::OnnxRuntime][..] } else { &[Backend::Embedded] };
    let load = |&backend: &Backend| -> (String, Box<dyn Estimator>) {
        (backend.to_string(), model::load(&source, backend, None).expect("the model loads"))
    };
    let fit: (String, Box<dyn Estimator>) = ("fit".into(), Box::new(Fit::new(None)));
    for (name, model) in backends.iter().map(load).chain([fit]) {
        let map = |i: usize| {
            let mut bins: Vec<_> =
                (0..filled).map(|n| ((i * 37 + n * 211) % FRONT_BINS, 0.1 + 0.01 * n as f32)).collect();
            bins.sort_unstable_by_key(|bin| bin.0);
            SparseMap { bins: bins.into_iter().map(|(b, v)| (b as Bin, BinSum::one([v; 3], false))).collect() }
        };
        let maps: Vec<SparseMap> = (0..MAPS).map(map).collect();
        let maps: Vec<&SparseMap> = maps.iter().collect();
        let light = LocalLight { direction: Vec3::new(0.0, 0.6, 0.8), sun: Vec3::ONE, sky: Vec3::splat(0.2) };
        let lights = vec![light.into(); MAPS];
        let mut group = criterion.benchmark_group(format!("infer/{name}"));
        group.throughput(Throughput::Elements(MAPS as u64)).sampling_mode(SamplingMode::Flat).sample_size(20);
        for threads in [1, 2] {
            let mut sessions: Vec<_> = (0..threads).map(|_| model.session().expect("a session")).collect();
            let mut out = vec![Estimate::default(); MAPS];
            group.bench_function(format!("{threads} thread{}", if threads == 1 { "" } else { "s" }), |b| {
                b.iter(|| {
                    let share = MAPS / threads;
                    std::thread::scope(|scope| {
                        for (i, (session, out)) in sessions.iter_mut().zip(out.chunks_mut(share)).enumerate() {
                            let maps = &maps[i * share..][..share];
                            let lights = model.contract().light.wanted().then(|| &lights[i * share..][..share]);
                            scope.spawn(move || session.estimate(maps, lights, out).expect("an estimate"));
                        }
                    });
                });
            });
        }
        group.finish();
    }
}

criterion_group!(benches, infer);
criterion_main!(benches);
