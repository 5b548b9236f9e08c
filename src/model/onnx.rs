//! An ONNX model on an engine: the network as an estimator.

use std::borrow::Cow;
use std::path::Path;

use super::backend::Backend;
use super::contract::Contract;
use super::embedded::{self, Prepared};
use super::engine::Engine;
use super::estimator::{Estimate, Estimator, Session};
use super::library::{self, Library, Wanted};
use super::runtime::{self, OnnxRuntime};
use super::session::{self, OnnxSession};
use super::source::ModelSource;
use crate::base::key::{Key, KeyBuilder};
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::scene::reflectance::{Bin, BinSum, SparseMap};

/// Loads a model on an engine, and tries it.
///
/// `library` is the shared library of ONNX Runtime 1.17 or newer; if it is `None`, the environment's `ORT_DYLIB_PATH` names the
/// library. A library named in either way must work, unless `backend` is embedded. A process can hold one library only.
///
/// # Errors
/// A model that cannot be read, is no ONNX file, breaks the contract or does not run; a library that is asked for and
/// missing, incomplete, too old, or not ONNX Runtime; a second, different library.
pub fn load(source: &ModelSource, backend: Backend, library: Option<&Path>) -> Result<Box<dyn Estimator>> {
    let bytes = source.read()?;
    let contract = Contract::read(source.label(), &bytes)?;
    let environment = std::env::var_os(library::VARIABLE);
    let (library, note) = library::open(&Wanted::new(backend, library, environment.as_deref()))?;
    let key = KeyBuilder::new("gonio model 2").field(&bytes).finish();
    let size = bytes.len() as u64;
    let on = match library {
        Some(library) => On::Runtime { library, bytes },
        None => On::Embedded(Prepared::new(&contract, &bytes).map_err(|e| {
            Error::malformed(source.label(), format!("the built-in engine cannot run this model: {e}"))
        })?),
    };
    let model = OnnxModel { key, contract, size, note, on };
    model.try_once()?;
    Ok(Box::new(model))
}

struct OnnxModel {
    contract: Contract,
    size: u64,
    key: Key,
    note: Option<String>,
    on: On,
}

/// The engine that the model runs on.
enum On {
    Embedded(Prepared),
    Runtime { library: Library, bytes: Cow<'static, [u8]> },
}

impl OnnxModel {
    /// Runs an empty map and one map of every size.
    fn try_once(&self) -> Result<()> {
        let bins = (0u16..).map(|bin: Bin| (bin, BinSum::default()));
        let map = |count: usize| SparseMap { bins: bins.clone().take(count).collect() };
        let maps: Vec<SparseMap> = [0].into_iter().chain(self.contract.input.sizes()).map(map).collect();
        let lights = vec![session::OVERHEAD.into(); maps.len()];
        let lights = self.contract.light.wanted().then_some(lights.as_slice());
        let maps: Vec<&SparseMap> = maps.iter().collect();
        self.session()?.estimate(&maps, lights, &mut vec![Estimate::default(); maps.len()])
    }

    /// The number of maps of each size that go through the engine at once.
    fn batches(&self) -> Vec<usize> {
        let sizes = self.contract.input.sizes().into_iter();
        let batch = |size| match self.on {
            On::Embedded(_) => embedded::micro_batch(self.contract.input, size),
            On::Runtime { .. } => runtime::MICRO_BATCH,
        };
        sizes.map(batch).collect()
    }
}

impl Estimator for OnnxModel {
    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn describe(&self) -> String {
        let Contract { model, kind, input, light, version, .. } = &self.contract;
        let light = if light.wanted() { " and light" } else { "" };
        let model = format!("{} version {version} ({kind}, {input}{light})", model.display());
        let origin = match &self.on {
            On::Embedded(_) => ", built in".to_owned(),
            On::Runtime { library, .. } => format!(" from {}", library.path.display()),
        };
        let engine = self.engine() + &origin;
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
        self.batches().into_iter().max().unwrap_or(1)
    }

    fn memory(&self, sessions: usize) -> Bytes {
        // Above what was measured for a set network of 3.7 MB. Convolutions hold larger activations.
        let (shared, each) = match self.on {
            On::Embedded(_) => (3 * self.size + 24 * Bytes::MIB, 8 * Bytes::MIB),
            On::Runtime { .. } => (self.size + 48 * Bytes::MIB, 2 * self.size + 32 * Bytes::MIB),
        };
        Bytes(shared.saturating_add(each.saturating_mul(sessions as u64)))
    }

    fn session(&self) -> Result<Box<dyn Session>> {
        let engine: Box<dyn Engine> = match &self.on {
            On::Embedded(prepared) => Box::new(prepared.engine()),
            On::Runtime { library, bytes } => {
                let engine = OnnxRuntime::new(library, &self.contract, bytes);
                Box::new(engine.map_err(|e| {
                    let found = format!("{} cannot run this model: {e}", library.version());
                    Error::malformed(&self.contract.model, found)
                })?)
            }
        };
        Ok(Box::new(OnnxSession::new(self.contract.clone(), self.batches(), engine)))
    }
}
