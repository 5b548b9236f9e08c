//! An ONNX model on an engine. Maps are cut into micro-batches of one fixed size, the last filled up with empty maps, so
//! that the engine always does the same arithmetic in the same order.

use std::any::Any;
use std::borrow::Cow;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::Path;

use super::contract::Contract;
use super::embedded::{self, Plan};
use super::library::{self, Choice, Library};
use super::runtime::{self, OnnxRuntime};
use super::{Backend, Estimator, ModelSource, Session};
use crate::base::key::{Key, KeyBuilder};
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::scene::Material;
use crate::scene::reflectance::BINS;

/// Runs one micro-batch: `maps` `[m, C, 60, 120]` and `lights` `[m, 3]` (empty if the model takes none) into `mu`
/// `[m, 7]`. Says why it could not.
pub(super) trait Engine: Send {
    fn run(&mut self, maps: &[f32], lights: &[f32], mu: &mut [f32]) -> Result<(), String>;
}

/// Runs an engine's code; its panic becomes an error like any other.
pub(super) fn guarded<T>(work: impl FnOnce() -> Result<T, String>) -> Result<T, String> {
    catch_unwind(AssertUnwindSafe(work)).unwrap_or_else(|panic| Err(format!("the engine gave up: {}", words(&*panic))))
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
    let mut tried = [Material::default()];
    let light = model.contract.light.then_some(UP.as_slice());
    model.session()?.estimate(&vec![0.0; model.contract.channels * BINS], light, &mut tried)?;
    Ok(Box::new(model))
}

/// What stands for the sun beside an empty map.
const UP: [f32; 3] = [0.0, 0.0, 1.0];

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
        let Contract { model, kind, channels, light, version, .. } = &self.contract;
        let light = if *light { " and light" } else { "" };
        let model = format!("{} version {version} ({kind}, {channels} channels{light})", model.display());
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
            On::Embedded(_) => embedded::MICRO_BATCH,
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
        let lights = if self.contract.light { batch * UP.len() } else { 0 };
        Ok(Box::new(OnnxSession {
            contract: self.contract.clone(),
            batch,
            maps: vec![0.0; batch * self.contract.channels * BINS],
            lights: vec![0.0; lights],
            mu: vec![0.0; batch * Material::LEN],
            engine,
        }))
    }
}

struct OnnxSession {
    contract: Contract,
    batch: usize,
    /// One micro-batch, for the chunk that does not fill it.
    maps: Vec<f32>,
    lights: Vec<f32>,
    mu: Vec<f32>,
    engine: Box<dyn Engine>,
}

impl Session for OnnxSession {
    fn estimate(&mut self, maps: &[f32], lights: Option<&[f32]>, out: &mut [Material]) -> Result<()> {
        let wrong = |found: String| Error::malformed(&self.contract.model, found);
        let map = self.contract.channels * BINS;
        if maps.len() != out.len() * map {
            return Err(wrong(format!(
                "{} values of maps for {} materials; {map} a map are needed",
                maps.len(),
                out.len()
            )));
        }
        let light = lights.map_or(0, |_| UP.len());
        if lights.is_some() != self.contract.light || lights.is_some_and(|l| l.len() != out.len() * light) {
            let needed =
                if self.contract.light { "needs a light of 3 values beside each map" } else { "takes no light" };
            return Err(wrong(format!("the model {needed}; {} values came", lights.map_or(0, <[f32]>::len))));
        }
        let lights = lights.unwrap_or_default();
        for (chunk, out) in out.chunks_mut(self.batch).enumerate() {
            let (first, n) = (chunk * self.batch, out.len());
            let (mut maps, mut lights) = (&maps[first * map..][..n * map], &lights[first * light..][..n * light]);
            if n < self.batch {
                self.maps[..n * map].copy_from_slice(maps);
                self.maps[n * map..].fill(0.0);
                self.lights[..n * light].copy_from_slice(lights);
                self.lights[n * light..].chunks_exact_mut(UP.len()).for_each(|l| l.copy_from_slice(&UP));
                (maps, lights) = (&self.maps, &self.lights);
            }
            self.engine.run(maps, lights, &mut self.mu).map_err(wrong)?;
            for (row, (out, mu)) in out.iter_mut().zip(self.mu.chunks_exact(Material::LEN)).enumerate() {
                *out = material(mu).map_err(|found| wrong(format!("map {} of {found}", first + row)))?;
            }
        }
        Ok(())
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
