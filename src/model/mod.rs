//! The estimator: reflectance maps in, materials out. An estimator is a network or, where the light is known, the [`Fit`]. A
//! network is an ONNX file. One of two engines runs it: rten, which is built in, or an ONNX Runtime library.
//!
//! Invariants:
//! - [`load`] finds every fault of a model or a library before anything starts, and reports it in one sentence: what was
//!   found and what is needed. [`load`] also tries the model once, on an empty map.
//! - The bits of a map's material do not depend on the maps beside it, on their number, or on the session. The engine always
//!   sees a fixed number of maps, the missing ones empty, in a shape that the map alone decides (`pack`), and runs on one
//!   thread.
//! - The two engines agree to 1e-4, not to the bit; nor does one engine agree to the bit between processors of different
//!   instruction sets. So the recipe of a result holds both [`Estimator::key`] and [`Estimator::engine`].
//! - The model bounds the memory: its file (at most 1 GiB), a few copies of its weights, and the activations of one
//!   micro-batch for each session ([`Estimator::memory`]). A model is a program: one that asks for huge intermediate arrays
//!   gets them, so trust a model only as far as you trust a program from the same source.

#![warn(clippy::cast_possible_truncation)]

mod backend;
mod contract;
mod declared;
mod elf;
mod embedded;
mod engine;
mod estimator;
mod fit;
mod library;
mod onnx;
mod pack;
mod proto;
mod rewrite;
mod runtime;
mod session;
mod source;

pub use backend::Backend;
pub use contract::Contract;
pub use elf::complete;
pub(crate) use embedded::one_thread;
pub(crate) use estimator::Session;
pub use estimator::{Estimate, Estimator, MapLight};
pub use fit::Fit;
pub use onnx::load;
pub use rewrite::for_rten;
pub use source::{BUILT_IN, ModelSource};
