//! An ONNX model on an engine. Maps of a size go together, in micro-batches of one fixed count, the last filled up with
//! empty maps, so that the engine always does the same arithmetic in the same order.

use std::any::Any;
use std::borrow::Cow;
use std::iter;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use glam::Vec3;

use super::contract::Contract;
use super::embedded::{self, Plan};
use super::library::{self, Choice, Library};
use super::pack::place;
use super::runtime::{self, OnnxRuntime};
use super::{Backend, Estimate, Estimator, ModelSource, Session};
use crate::base::key::{Key, KeyBuilder};
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::scene::Material;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{Bin, BinSum, SparseMap};

/// A micro-batch as a model eats it.
#[derive(Clone, Copy)]
pub(super) struct Maps<'a> {
    /// The place of their size among the sizes of the input.
    pub size: usize,
    /// The maps, as [`Contract::shape`] says.
    pub values: &'a [f32],
    /// As [`LightInput`] says, one after the other; empty if the model takes none.
    pub lights: &'a [f32],
}

/// Runs one micro-batch into `mu` `[m, 7]`. Says why it could not.
pub(super) trait Engine: Send {
    fn run(&mut self, maps: Maps<'_>, mu: &mut [f32]) -> Result<(), String>;
}

/// Runs an engine's code; its panic becomes an error like any other.
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    let done = catch_unwind(AssertUnwindSafe(work));
    clear_upper_halves();
    done.unwrap_or_else(|panic| Err(format!("the engine gave up: {}", words(&*panic))))
}

/// An engine may leave the upper halves of the vector registers in use, and threads that are spawned from then on inherit
/// that. Code for narrower vectors, ours, then waits for them: the fit took 25 us a map in place of 10.
fn clear_upper_halves() {
    #[cfg(target_arch = "x86_64")]
    if std::arch::is_x86_feature_detected!("avx") {
        #[target_feature(enable = "avx")]
        fn clear() {
            std::arch::x86_64::_mm256_zeroupper();
        }
        // SAFETY: the processor has AVX, and no caller expects upper halves to outlive a call.
        unsafe { clear() };
    }
}

fn words(panic: &(dyn Any + Send)) -> &str {
    let text = panic.downcast_ref::<String>().map(String::as_str);
    text.or_else(|| panic.downcast_ref::<&str>().copied()).unwrap_or("no reason given")
}

/// See [`super::load`].
pub(super) fn load(source: &ModelSource, backend: Backend, library: Option<&Path>) -> Result<Box<dyn Estimator>> {
    let bytes = source.read()?;
    let (contract, proto) = Contract::read(source.label(), &bytes)?;
    let environment = std::env::var_os(library::VARIABLE);
    let (library, note) = library::open(&Choice::new(backend, library, environment.as_deref()))?;
    let key = KeyBuilder::new("gonio model 2").field(&bytes).finish();
    let size = bytes.len() as u64;
    let on = match library {
        Some(library) => On::Runtime { library, bytes },
        None => {
            let plan = Plan::new(&contract, &proto).map_err(|e| {
                Error::malformed(source.label(), format!("the built-in engine cannot run this model: {e}"))
            })?;
            On::Embedded(plan)
        }
    };
    let model = OnnxModel { key, contract, size, note, on };
    // An empty map, and one of every size.
    let bins = |count: usize| SparseMap { bins: (0..count).map(|b| (b as Bin, BinSum::default())).collect() };
    let maps: Vec<SparseMap> = [0].into_iter().chain(model.contract.input.sizes()).map(bins).collect();
    let lights = vec![OVERHEAD; maps.len()];
    let lights = model.contract.light.wanted().then_some(lights.as_slice());
    let maps: Vec<&SparseMap> = maps.iter().collect();
    model.session()?.estimate(&maps, lights, &mut vec![Estimate::default(); maps.len()])?;
    Ok(Box::new(model))
}

/// What stands for the light beside an empty map.
const OVERHEAD: LocalLight = LocalLight { direction: Vec3::Z, sun: Vec3::ONE, sky: Vec3::ZERO };

/// How far a rounding may carry a component outside [0, 1].
const SLACK: f32 = 1e-4;

struct OnnxModel {
    contract: Contract,
    size: u64,
    key: Key,
    note: Option<String>,
    on: On,
}

enum On {
    Embedded(Plan),
    Runtime { library: Library, bytes: Cow<'static, [u8]> },
}

impl Estimator for OnnxModel {
    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn describe(&self) -> String {
        let Contract { model, kind, input, light, version, .. } = &self.contract;
        let light = if light.wanted() { " and light" } else { "" };
        let model = format!("{} version {version} ({kind}, {input}{light})", model.display());
        let place = match &self.on {
            On::Embedded(_) => ", built in".to_owned(),
            On::Runtime { library, .. } => format!(" from {}", library.path.display()),
        };
        let engine = self.engine() + &place;
        let note = self.note.as_ref().map_or(String::new(), |note| format!("; {note}"));
        format!("{model} on {engine}{note}")
    }

    fn key(&self) -> Key {
        self.key
    }

    fn engine(&self) -> String {
        match &self.on {
            On::Embedded(_) => embedded::VERSION.to_owned(),
            On::Runtime { library, .. } => library.version(),
        }
    }

    fn micro_batch(&self) -> usize {
        match self.on {
            On::Embedded(_) => embedded::micro_batch(self.contract.input),
            On::Runtime { .. } => runtime::MICRO_BATCH,
        }
    }

    fn memory(&self, sessions: usize) -> Bytes {
        // Above what was measured: for a set network of 3.7 MB, 28 MiB on tract however many sessions, and on ONNX
        // Runtime 46 MiB and 12 more a session. Convolutions hold larger activations.
        let (shared, each) = match self.on {
            On::Embedded(_) => (3 * self.size + 24 * Bytes::MIB, 8 * Bytes::MIB),
            On::Runtime { .. } => (self.size + 48 * Bytes::MIB, 2 * self.size + 32 * Bytes::MIB),
        };
        Bytes(shared.saturating_add(each.saturating_mul(sessions as u64)))
    }

    fn session(&self) -> Result<Box<dyn Session>> {
        let engine: Box<dyn Engine> = match &self.on {
            On::Embedded(plan) => Box::new(plan.clone()),
            On::Runtime { library, bytes } => {
                let engine = OnnxRuntime::new(library, &self.contract, bytes);
                Box::new(engine.map_err(|e| {
                    let found = format!("{} cannot run this model: {e}", library.version());
                    Error::malformed(&self.contract.model, found)
                })?)
            }
        };
        let batch = self.micro_batch();
        Ok(Box::new(OnnxSession {
            contract: self.contract.clone(),
            batch,
            values: Vec::new(),
            lights: Vec::new(),
            mu: vec![0.0; batch * Material::LEN],
            engine,
        }))
    }
}

struct OnnxSession {
    contract: Contract,
    batch: usize,
    /// One micro-batch.
    values: Vec<f32>,
    lights: Vec<f32>,
    mu: Vec<f32>,
    engine: Box<dyn Engine>,
}

impl Session for OnnxSession {
    fn estimate(&mut self, maps: &[&SparseMap], lights: Option<&[LocalLight]>, out: &mut [Estimate]) -> Result<()> {
        self.check(maps.len(), lights, out.len())?;
        let lights = lights.unwrap_or_default();
        let input = self.contract.input;
        let deviation = self.contract.deviation.unwrap_or([f32::NAN; Material::LEN]);
        let sizes = input.sizes();
        let places: Vec<usize> = maps.iter().map(|map| place(&sizes, map)).collect();
        for (size, &bins) in sizes.iter().enumerate() {
            let alike: Vec<usize> = (0..maps.len()).filter(|&i| places[i] == size).collect();
            for chunk in alike.chunks(self.batch) {
                self.run(size, input.values(bins), chunk, maps, lights)?;
                for (&i, mu) in chunk.iter().zip(self.mu.chunks_exact(Material::LEN)) {
                    let fault = |found| Error::malformed(&self.contract.model, format!("map {i} of {found}"));
                    out[i] = Estimate { material: material(mu).map_err(fault)?, deviation };
                }
            }
        }
        Ok(())
    }
}

impl OnnxSession {
    /// Whether there is an answer, and a light if one is wanted, for each of `maps` maps.
    fn check(&self, maps: usize, lights: Option<&[LocalLight]>, answers: usize) -> Result<()> {
        let wrong = |found: String| Err(Error::malformed(&self.contract.model, found));
        if maps != answers {
            return wrong(format!("{maps} maps came for {answers} materials"));
        }
        if lights.is_some() != self.contract.light.wanted() || lights.is_some_and(|l| l.len() != maps) {
            let needed = if self.contract.light.wanted() { "needs a light beside each map" } else { "takes no light" };
            return wrong(format!("the model {needed}; {} came", lights.map_or(0, <[LocalLight]>::len)));
        }
        Ok(())
    }

    /// Runs one micro-batch of maps of a size, `each` values long.
    fn run(
        &mut self,
        size: usize,
        each: usize,
        chosen: &[usize],
        maps: &[&SparseMap],
        lights: &[LocalLight],
    ) -> Result<()> {
        self.values.clear();
        self.values.resize(self.batch * each, 0.0);
        for (&i, values) in chosen.iter().zip(self.values.chunks_exact_mut(each)) {
            self.contract.input.write(maps[i], values);
        }
        self.lights.clear();
        if self.contract.light.wanted() {
            let empty = iter::repeat_n(&OVERHEAD, self.batch - chosen.len());
            for light in chosen.iter().map(|&i| &lights[i]).chain(empty) {
                self.contract.light.write(light, &mut self.lights);
            }
        }
        let batch = Maps { size, values: &self.values, lights: &self.lights };
        self.engine.run(batch, &mut self.mu).map_err(|found| Error::malformed(&self.contract.model, found))
    }
}

fn material(mu: &[f32]) -> Result<Material, String> {
    let mut v = [0.0; Material::LEN];
    for ((v, &mu), name) in v.iter_mut().zip(mu).zip(Material::NAMES) {
        if !(-SLACK..=1.0 + SLACK).contains(&mu) {
            return Err(format!("this batch has {name} = {mu}; the contract wants [0, 1]"));
        }
        *v = mu.clamp(0.0, 1.0);
    }
    Ok(Material::from(v))
}
