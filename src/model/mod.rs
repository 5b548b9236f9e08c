//! The estimator: reflectance maps in, materials out. It is a network or, where the light is known, the [`Fit`]. A network is
//! an ONNX file; one of two engines runs it: tract, built in, or an ONNX Runtime library found when the run is planned.
//!
//! Invariants:
//! - Whatever is wrong with a model or a library is found by [`load`], before anything starts, and told in one sentence:
//!   what was found and what is needed. [`load`] also tries the model once, on an empty map.
//! - A map's material has the same bits whatever maps lie beside it, however many are given at once, and whichever
//!   session takes it: an engine always sees one fixed number of maps ([`Estimator::micro_batch`]), the rest of them
//!   empty, in a shape that depends on the map alone (`pack`), and runs on the caller's thread alone.
//! - The two engines agree to 1e-4, not to the bit, nor does one engine to the bit on processors of other instruction
//!   sets. What is made with a model is therefore known by its [`Estimator::key`] and its [`Estimator::engine`].
//! - Memory is bounded by the model: its file (at most 1 GiB) and a few copies of its weights, plus the activations of
//!   one micro-batch for each session ([`Estimator::memory`]). A model is a program: one that asks for huge
//!   intermediate arrays gets them, so take models from where you take programs.

mod contract;
mod elf;
mod embedded;
mod fit;
mod library;
mod onnx;
mod pack;
mod runtime;
mod source;

use std::fmt;
use std::path::Path;
use std::str::FromStr;

use serde::Serialize;

pub use contract::{Contract, Input, LightInput};
pub use fit::Fit;
pub use source::{BUILT_IN, BuiltIn, ModelSource};

use crate::base::Result;
use crate::base::key::Key;
use crate::base::units::Bytes;
use crate::scene::Material;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::SparseMap;

/// What turns reflectance maps into materials. Shared by all workers; each makes its own [`Session`].
pub trait Estimator: Send + Sync {
    /// What the model eats, and what it says of itself.
    fn contract(&self) -> &Contract;

    /// Model, engine, library and version, in one line for the log.
    fn describe(&self) -> String;

    /// The key of the model's bytes. The same model on the same engine gives equal materials for equal maps.
    fn key(&self) -> Key;

    /// The engine and its version.
    fn engine(&self) -> String;

    /// Maps that go through the engine at once. A multiple of it wastes nothing.
    fn micro_batch(&self) -> usize;

    /// Bytes that the estimator and this many sessions will hold: an estimate from the model's size.
    fn memory(&self, sessions: usize) -> Bytes;

    /// Makes what one worker needs to estimate.
    ///
    /// # Errors
    /// What the engine says, when it refuses.
    fn session(&self) -> Result<Box<dyn Session>>;
}

/// One worker's way through the model.
pub trait Session: Send {
    /// Estimates the material of each of `maps`, as many as `out` has.
    ///
    /// `lights` is the light of each map's triangle; given just when the contract says so. Components come out in [0, 1].
    ///
    /// # Errors
    /// Lengths that do not fit, a failing engine, or a component that is no number or outside [0, 1] by over 1e-4.
    fn estimate(&mut self, maps: &[&SparseMap], lights: Option<&[LocalLight]>, out: &mut [Estimate]) -> Result<()>;
}

/// What a map says of its triangle.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The material.
    pub material: Material,
    /// Standard deviations of its components, in the order of [`Material::NAMES`]; NaN where the estimator does not say.
    pub deviation: [f32; Material::LEN],
}

impl Default for Estimate {
    fn default() -> Self {
        Estimate { material: Material::default(), deviation: [f32::NAN; Material::LEN] }
    }
}

/// Which engine runs the model.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// A configured ONNX Runtime library (which must then work), else one that lies where libraries lie, else the
    /// built-in engine.
    #[default]
    Auto,
    /// The built-in engine, tract. Needs nothing.
    Embedded,
    /// An ONNX Runtime library, or an error.
    OnnxRuntime,
}

impl Backend {
    /// All backends, as pipeline files name them.
    pub const NAMES: [(&str, Backend); 3] =
        [("auto", Backend::Auto), ("embedded", Backend::Embedded), ("onnxruntime", Backend::OnnxRuntime)];
}

impl FromStr for Backend {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let known = Self::NAMES.iter().find(|(name, _)| *name == text);
        known.map(|(_, backend)| *backend).ok_or_else(|| format!("{text:?} is none of auto, embedded, onnxruntime"))
    }
}

impl fmt::Display for Backend {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(Self::NAMES.iter().find(|(_, b)| b == self).map_or("", |(name, _)| name))
    }
}

/// Loads a model on an engine, and tries it.
///
/// `library` is an ONNX Runtime (1.17 or newer) shared library; if `None`, the environment's `ORT_DYLIB_PATH` is used.
/// One configured in either way must work, unless `backend` is embedded. A process can hold one such library only.
///
/// # Errors
/// A model that cannot be read, is no ONNX file, breaks the contract or does not run; a library that is asked for and
/// missing, incomplete, too old, or not ONNX Runtime; a second, different library.
pub fn load(source: &ModelSource, backend: Backend, library: Option<&Path>) -> Result<Box<dyn Estimator>> {
    onnx::load(source, backend, library)
}
