//! Materials a second: each engine, on one thread and on two, at its own micro-batch. One element is one map; a second
//! over elements a second is the time of one map. `ORT_DYLIB_PATH` names the library; without one, its half is left out.
//! `GONIO_MODEL` names another model than the built-in one.
#![expect(clippy::expect_used, reason = "a benchmark that cannot start should stop")]

use std::path::Path;

use criterion::{Criterion, SamplingMode, Throughput, criterion_group, criterion_main};
use gonio::model::{self, Backend, ModelSource};
use gonio::scene::Material;
use gonio::scene::reflectance::{BINS, FRONT_BINS};

const MAPS: usize = 512;
/// Bins that a map fills; the median of real scenes.
const FILLED: usize = 16;

fn infer(criterion: &mut Criterion) {
    let name = std::env::var("GONIO_MODEL").unwrap_or_else(|_| model::BUILT_IN[0].name.into());
    let source = ModelSource::named(&name, Path::new(""));
    let library = std::env::var_os("ORT_DYLIB_PATH").is_some_and(|v| !v.is_empty());
    let backends = if library { &[Backend::Embedded, Backend::OnnxRuntime][..] } else { &[Backend::Embedded] };
    for &backend in backends {
        let model = model::load(&source, backend, None).expect("the model loads");
        let channels = model.contract().channels;
        let mut maps = vec![0.0; MAPS * channels * BINS];
        for (i, map) in maps.chunks_exact_mut(channels * BINS).enumerate() {
            for n in 0..FILLED {
                let bin = (i * 37 + n * 211) % FRONT_BINS;
                (0..channels).for_each(|c| map[c * BINS + bin] = if c == 3 { 1.0 } else { 0.1 + 0.01 * n as f32 });
            }
        }
        let lights = vec![0.6; if model.contract().light { MAPS * 3 } else { 0 }];
        let mut group = criterion.benchmark_group(format!("infer/{backend}"));
        group.throughput(Throughput::Elements(MAPS as u64)).sampling_mode(SamplingMode::Flat).sample_size(20);
        for threads in [1, 2] {
            let mut sessions: Vec<_> = (0..threads).map(|_| model.session().expect("a session")).collect();
            let mut out = vec![Material::default(); MAPS];
            group.bench_function(format!("{threads} thread{}", if threads == 1 { "" } else { "s" }), |b| {
                b.iter(|| {
                    let share = MAPS / threads;
                    std::thread::scope(|scope| {
                        for (i, (session, out)) in sessions.iter_mut().zip(out.chunks_mut(share)).enumerate() {
                            let maps = &maps[i * share * channels * BINS..][..share * channels * BINS];
                            let lights = (!lights.is_empty()).then(|| &lights[i * share * 3..][..share * 3]);
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
