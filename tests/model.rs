//! The estimator from outside: contracts, garbage, batching, and agreement of the two engines. What needs ONNX Runtime
//! runs where ORT_DYLIB_PATH names a library, and else says that it was skipped.
#![expect(
    clippy::unwrap_used,
    clippy::panic,
    clippy::print_stdout,
    reason = "a test fails by panicking, and says what it skips"
)]

use std::collections::BTreeSet;
use std::path::{Path, PathBuf};

use glam::Vec3;
use gonio::internals::base::Result;
use gonio::internals::model::{self, Backend, Estimate, Estimator, Fit, MapLight, ModelSource};
use gonio::internals::scene::light::LocalLight;
use gonio::internals::scene::reflectance::{Bin, BinSum, FRONT_BINS, Layout, SparseMap};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

fn tiny(name: &str) -> ModelSource {
    ModelSource::named(&format!("{name}.onnx"), &Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/models"))
}

fn load(source: &ModelSource, backend: Backend) -> Result<Box<dyn Estimator>> {
    model::load(source, backend, None)
}

fn refusal(source: &ModelSource, backend: Backend) -> String {
    load(source, backend).err().unwrap_or_else(|| panic!("{source:?} was accepted on {backend}")).to_string()
}

/// The engines that can be tested here.
fn backends() -> Vec<Backend> {
    if std::env::var_os("ORT_DYLIB_PATH").is_none_or(|v| v.is_empty()) {
        println!("skipped for ONNX Runtime: ORT_DYLIB_PATH names no library");
        return vec![Backend::Embedded];
    }
    vec![Backend::Embedded, Backend::OnnxRuntime]
}

/// A model of each make: a convolution, a set of bins taken out of a dense map, one of bins, a light, and what is shipped.
fn sound() -> Vec<ModelSource> {
    let shipped = model::BUILT_IN.iter().map(|m| ModelSource::named(m.name, Path::new("")));
    ["conv4", "set4", "bins7", "light3", "light9"].map(tiny).into_iter().chain(shipped).collect()
}

/// Maps as scenes fill them: a few front bins each; the first is empty, the second full.
fn maps(count: usize) -> Vec<SparseMap> {
    let mut random = Pcg64Mcg::seed_from_u64(7);
    let map = |i: usize| {
        let filled = [0, FRONT_BINS].get(i).copied().unwrap_or_else(|| random.random_range(3..60));
        let bins: BTreeSet<usize> =
            (0..filled).map(|n| if filled == FRONT_BINS { n } else { random.random_range(0..FRONT_BINS) }).collect();

        let mut seen = || BinSum::one([0.0; 3].map(|_: f32| random.random_range(0.0..1.0)), false);
        SparseMap { bins: bins.into_iter().map(|bin| (bin as Bin, seen())).collect() }
    };
    (0..count).map(map).collect()
}

fn sun(z: f32) -> LocalLight {
    LocalLight { direction: Vec3::new(0.0, 0.6, z), sun: Vec3::ONE, sky: Vec3::ZERO }
}

/// Estimates in batches of this size, each batch in a session of its own.
fn estimate<'a>(model: &dyn Estimator, maps: impl IntoIterator<Item = &'a SparseMap>, batch: usize) -> Vec<[f32; 7]> {
    let maps: Vec<&SparseMap> = maps.into_iter().collect();
    // The light follows from the map, wherever the map lies in a batch.
    let light = |m: &&SparseMap| sun(if m.bins.len().is_multiple_of(2) { 0.8 } else { -0.8 });
    let mut out = vec![Estimate::default(); maps.len()];
    for (maps, out) in maps.chunks(batch).zip(out.chunks_mut(batch)) {
        let lights: Vec<MapLight<'_>> = maps.iter().map(light).map(MapLight::from).collect();
        let lights = model.contract().light.wanted().then_some(lights.as_slice());
        model.session().unwrap().estimate(maps, lights, out).unwrap();
    }
    out.into_iter().map(|estimate| estimate.material.to_array()).collect()
}

#[test]
fn bits_do_not_depend_on_the_batch_or_the_neighbours() {
    for backend in backends() {
        for source in sound() {
            let model = load(&source, backend).unwrap();
            let name = model.describe();
            let maps = maps(67);
            let alone = estimate(&*model, &maps, 1);
            for batch in [7, 64] {
                assert_eq!(alone, estimate(&*model, &maps, batch), "{name}, {batch} at once");
            }
            // Each row of a micro-batch in turn: the first maps move along by one.
            for shift in 1..model.micro_batch() {
                let moved = estimate(&*model, maps[..shift].iter().chain(&maps[..8]), shift + 8);
                assert_eq!(alone[..8], moved[shift..], "{name}, moved by {shift}");
            }
            assert!(alone.windows(2).any(|w| w[0] != w[1]), "{name} does not look at its maps");
        }
    }
}

#[test]
fn engines_agree() {
    let backends = backends();
    for source in sound() {
        let results: Vec<_> = backends
            .iter()
            .map(|b| {
                let model = load(&source, *b).unwrap();
                estimate(&*model, &maps(20), 20)
            })
            .collect();
        for other in &results[1..] {
            for (a, b) in results[0].iter().flatten().zip(other.iter().flatten()) {
                assert!((a - b).abs() <= 1e-4, "{source:?}: {a} {b}");
            }
        }
    }
}

#[test]
fn a_process_holds_one_library() {
    let Some(&backend) = backends().get(1) else { return };
    let held = PathBuf::from(std::env::var_os("ORT_DYLIB_PATH").unwrap()).canonicalize().unwrap();
    let said = load(&tiny("light3"), backend).unwrap().describe();
    assert!(said.contains("on ONNX Runtime 1.") && said.ends_with(&*held.to_string_lossy()), "{said}");
    // Any second file will do: it is refused before it is opened.
    let other = Path::new(env!("CARGO_MANIFEST_DIR")).join("Cargo.toml");
    let said = model::load(&tiny("light3"), backend, Some(&other)).err().unwrap().to_string();
    assert!(said.contains(&format!("this process already holds {}", held.display())), "{said}");
}

#[test]
fn workers_share_an_estimator() {
    for backend in backends() {
        let model = load(&tiny("set4"), backend).unwrap();
        let maps = maps(20);
        let alone = estimate(&*model, &maps, 20);
        std::thread::scope(|s| {
            let workers: Vec<_> = (0..4).map(|_| s.spawn(|| estimate(&*model, &maps, 5))).collect();
            workers.into_iter().for_each(|w| assert_eq!(w.join().unwrap(), alone));
        });
    }
}

#[test]
fn built_in_models_keep_the_contract() {
    for built_in in model::BUILT_IN {
        let source = ModelSource::named(built_in.name, Path::new("/nowhere"));
        let model = load(&source, Backend::Embedded).unwrap();
        model.contract().require(Layout::Lobe).unwrap();
        assert!(model.describe().starts_with(built_in.name), "{}", model.describe());
    }
}

#[test]
fn broken_contracts_are_refused_in_words() {
    let cases = [
        ("bad_kind", "gonio.kind is \"cube\"; it must be \"lobe\" or \"sphere\""),
        ("bad_training", "gonio.training must be one JSON object"),
        ("bare_training", "gonio.training is 3; it must be one JSON object"),
        ("no_metadata", "the metadata gonio.kind is missing"),
        ("no_version", "the metadata gonio.version is missing"),
        ("rows_61", "the input is map f32 [N, 4, 61, 120]; needed: map f32 [N, 3 or 4, 60, 120] or bins f32 [N, S, 7]"),
        ("channels_5", "the input is map f32 [N, 5, 60, 120]; needed"),
        ("outputs_8", "the output is mu f32 [N, 8]; needed"),
        ("fixed_batch", "map f32 [1, 4, 60, 120]; needed: map f32 [N, 3 or 4, 60, 120]"),
        ("map_misnamed", "the input is image f32"),
        ("mu_misnamed", "the output is y f32 [N, 7]; needed"),
        ("map_f64", "the input is map double [N, 4, 60, 120]; needed"),
        ("extra_input", "the input is gain f32 [N, 7]; needed"),
        ("extra_output", "the output is mu f32 [N, 7] and is also f32 [N, 7]; needed"),
        ("weights_outside", "lies in another file; export the model with all weights inside"),
        ("nan_on_empty", "map 0 of this batch has kd_r = NaN; the contract wants [0, 1]"),
        ("out_of_range", "the contract wants [0, 1]"),
        ("bins_8", "the input is bins f32 [N, S, 8]; needed"),
        ("fixed_bins", "the input is bins f32 [N, 24, 7]; needed"),
        ("no_bins", "the metadata gonio.bins is missing; a model with the input bins says there how many"),
        ("bins_zero", "the metadata gonio.bins is \"0\"; a model"),
        ("bad_deviation", "the metadata gonio.deviation is \"[0.1, 0, 2]\"; it must be a list of 7 numbers"),
        ("two_rows_a_map", "mu came out as"),
    ];
    for backend in backends() {
        for (name, words) in cases {
            let said = refusal(&tiny(name), backend);
            assert!(said.contains(words) && said.contains(&format!("{name}.onnx")), "{name} on {backend}: {said}");
        }
    }
}

#[test]
fn a_model_of_the_other_kind_is_refused_where_it_matters() {
    let model = load(&tiny("sphere"), Backend::Embedded).unwrap();
    assert_eq!(model.contract().kind, Layout::Sphere);
    let said = model.contract().require(Layout::Lobe).unwrap_err().to_string();
    assert!(said.ends_with("gonio.kind is sphere, and a model of kind lobe is needed here"), "{said}");
}

#[test]
fn calls_that_do_not_fit_are_refused() {
    let four = load(&tiny("conv4"), Backend::Embedded).unwrap();
    let light = load(&tiny("light3"), Backend::Embedded).unwrap();
    let map = SparseMap::default();
    for (model, maps, lights, words) in [
        (&four, &[][..], None, "0 maps came for 1 materials"),
        (&four, &[&map][..], Some(&[sun(0.8).into()][..]), "takes no light"),
        (&light, &[&map], None, "needs a light beside each map; 0 came"),
        (&light, &[&map], Some(&[sun(0.8).into(); 2][..]), "2 came"),
    ] {
        let said = model.session().unwrap().estimate(maps, lights, &mut [Estimate::default()]).unwrap_err().to_string();
        assert!(said.contains(words), "{said}");
    }
    four.session().unwrap().estimate(&[], None, &mut []).unwrap();
}

/// A file in a folder of its own.
fn file(folder: &tempfile::TempDir, bytes: &[u8]) -> ModelSource {
    let path = folder.path().join("m.onnx");
    std::fs::write(&path, bytes).unwrap();
    ModelSource::File(path)
}

#[test]
fn files_that_are_no_models_are_refused() {
    let folder = tempfile::tempdir().unwrap();
    let whole = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/models/light3.onnx")).unwrap();
    for backend in backends() {
        assert!(refusal(&ModelSource::File(PathBuf::from("/nowhere/m.onnx")), backend).contains("gonio-lobe-small"));
        assert!(refusal(&ModelSource::File(folder.path().to_owned()), backend).contains("it is a folder, not a file"));
        for bytes in [&b""[..], b"a text, no model\n", &[0xff; 4096], b"\x7fELF\x02\x01"] {
            let said = refusal(&file(&folder, bytes), backend);
            assert!(said.contains("not an ONNX file"), "{said}");
        }
        for length in (0..whole.len()).step_by(5) {
            refusal(&file(&folder, &whole[..length]), backend);
        }
    }
}

#[test]
fn a_weight_that_claims_more_than_it_holds_is_refused() {
    for backend in backends() {
        // 2^40 rows of 7 values, and a few bytes.
        let said = refusal(&tiny("huge_weight"), backend);
        assert!(said.contains("huge_weight.onnx") && said.contains("cannot run this model"), "{said}");
    }
}

#[test]
fn flipped_bits_never_panic() {
    let folder = tempfile::tempdir().unwrap();
    let whole = std::fs::read(Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/data/models/light3.onnx")).unwrap();
    let mut refused = 0;
    for backend in backends() {
        for bit in (0..whole.len() * 8).step_by(41) {
            let mut bytes = whole.clone();
            bytes[bit / 8] ^= 1 << (bit % 8);
            refused += usize::from(load(&file(&folder, &bytes), backend).is_err());
        }
    }
    assert!(refused > 20, "{refused}");
}

#[test]
fn keys_tell_models_and_engines_apart() {
    let key = |name, backend| {
        let loaded = load(&tiny(name), backend).unwrap();
        (loaded.key(), loaded.engine())
    };
    assert_eq!(key("light3", Backend::Embedded), key("light3", Backend::Embedded));
    assert_ne!(key("light3", Backend::Embedded), key("sphere", Backend::Embedded));
    if backends().len() > 1 {
        assert_ne!(key("light3", Backend::Embedded), key("light3", Backend::OnnxRuntime));
    }
}

#[test]
fn a_model_says_how_sure_it_is_and_the_fit_starts_there() {
    let map = SparseMap { bins: (0..8).map(|i| (9 + 300 * i, BinSum::one([0.15; 3], false))).collect() };
    let estimate = |estimator: &dyn Estimator, light: Option<LocalLight>| {
        let mut out = [Estimate::default()];
        let lights = light.map(|light| [light.into()]);
        estimator.session().unwrap().estimate(&[&map], lights.as_ref().map(|l| &l[..]), &mut out).unwrap();
        out[0]
    };
    let network = || load(&tiny("bins7"), Backend::Embedded).unwrap();
    let guess = estimate(&*network(), None);
    assert_eq!(guess.deviation, [0.1, 0.1, 0.1, 0.2, 0.2, 0.2, 0.25]);
    // Where no light comes, the map tells nothing that is not thought already; how rough it is the network does not know
    // well either, so that ks is a bit nearer to a matt surface's.
    let both = Fit::new(Some(network()));
    let dark = LocalLight { direction: Vec3::Z, sun: Vec3::ZERO, sky: Vec3::ZERO };
    let unlit = estimate(&both, Some(dark));
    let (found, thought) = (unlit.material, guess.material);
    assert!(found.kd.iter().zip(thought.kd).all(|(a, b)| (a - b).abs() < 1e-3), "{found:?} {thought:?}");
    assert!(found.ks.iter().zip(thought.ks).all(|(a, b)| (0.8 * b..b + 1e-3).contains(a)), "{found:?} {thought:?}");
    // Where it does, kd follows from the map.
    let lit = estimate(&both, Some(LocalLight { sun: Vec3::ONE, ..dark }));
    assert!(lit.material.kd.iter().all(|kd| (0.05..0.25).contains(kd)), "{lit:?}");
    assert!(lit.deviation[0] < unlit.deviation[0]);
    assert_ne!(both.key(), Fit::new(None).key());
    assert!(both.describe().contains("bins7.onnx"));
}
