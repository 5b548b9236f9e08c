//! rten, the built-in engine.
//!
//! rten runs in a pool of threads. Each session has a pool of one thread, so the work of a session is not shared out and its
//! bits do not depend on the machine. Where the system does not grant a session its thread, the session shares the one that
//! the model was loaded on. rten also starts a pool for the whole process, which only packs weights when a model is loaded and
//! is idle from then on; [`one_thread`] keeps that pool small. All of rten runs on such a thread: elsewhere it would share its
//! work out in a pool of rayon's own.

use std::env;
use std::error::Error;
use std::sync::Arc;
use std::thread;

use rten::{Model, ModelOptions, NodeId, RunOptions, ThreadPool, ValueOrView, ValueView};

use super::contract::{Contract, Input};
use super::engine::{Batch, Engine, guarded};
use super::rewrite;
use crate::scene::Material;

/// The engine and its version, for the log and the recipe.
pub(super) const VERSION: &str = "rten 0.27.0";

/// The number of maps of this size that go through the engine at once. rten packs some weights anew for each batch, so few
/// maps cost more each; of large maps fewer fit the processor's caches.
pub(super) fn micro_batch(input: Input, size: usize) -> usize {
    match input {
        Input::Dense { .. } => 1,
        Input::Bins { .. } => (1024 / size).clamp(1, 64),
    }
}

/// Limits rten's pool for the whole process to one thread.
///
/// # Safety
/// No other thread runs yet.
pub(crate) unsafe fn one_thread() {
    // SAFETY: no other thread reads the environment, since none runs.
    unsafe { env::set_var("RTEN_NUM_THREADS", "1") };
}

/// A model made ready, its weights packed once. All sessions share it.
#[derive(Clone)]
pub(super) struct Prepared {
    model: Arc<Model>,
    maps: NodeId,
    /// The input for the light and the number of its values.
    light: Option<(NodeId, usize)>,
    mu: NodeId,
    /// The thread that the model was loaded on.
    thread: Arc<ThreadPool>,
}

impl Prepared {
    /// Loads and optimises a model whose bytes keep the contract. An error says why it could not.
    pub(super) fn new(contract: &Contract, bytes: &[u8]) -> Result<Prepared, String> {
        let thread = Arc::new(own_thread().ok_or("the system grants no thread for the engine")?);
        on(&thread, || {
            let bytes = rewrite::for_rten(bytes)?;
            let model = ModelOptions::with_all_ops().prepack_weights(true).load(bytes).map_err(words)?;
            let node = |name| model.node_id(name).map_err(words);
            let light = contract.light.wanted().then(|| node("light")).transpose()?;
            let (maps, mu) = (node(contract.input.name())?, node("mu")?);
            let light = light.map(|id| (id, contract.light.values()));
            Ok(Prepared { maps, light, mu, model: Arc::new(model), thread: Arc::clone(&thread) })
        })
    }

    /// Starts the thread of one session, or shares the one that is there.
    pub(super) fn engine(&self) -> Embedded {
        let thread = own_thread().map_or_else(|| Arc::clone(&self.thread), Arc::new);
        Embedded { prepared: self.clone(), thread }
    }
}

/// A pool of one thread, if the system grants it.
fn own_thread() -> Option<ThreadPool> {
    let pool = ThreadPool::with_num_threads(1);
    // A pool that could not start its thread does its work where it is called.
    let here = thread::current().id();
    pool.run(|| thread::current().id() != here).then_some(pool)
}

/// Runs code of rten on a thread of its own.
fn on<T: Send>(thread: &ThreadPool, work: impl FnOnce() -> Result<T, String> + Send) -> Result<T, String> {
    thread.run(|| guarded(work))
}

/// The engine of one session.
pub(super) struct Embedded {
    prepared: Prepared,
    thread: Arc<ThreadPool>,
}

impl Engine for Embedded {
    fn run(&mut self, batch: Batch<'_>, mu: &mut [f32]) -> Result<(), String> {
        let Embedded { prepared, thread } = self;
        let options = RunOptions::default().with_thread_pool(Some(Arc::clone(thread)));
        on(thread, || {
            let count = mu.len() / Material::LEN;
            let mut inputs = vec![(prepared.maps, view(batch.shape, batch.maps)?)];
            if let Some((light, values)) = prepared.light {
                inputs.push((light, view(&[count, values], batch.lights)?));
            }
            let outputs = prepared.model.run(inputs, &[prepared.mu], Some(options)).map_err(words)?;
            let found = outputs.into_iter().next().ok_or("mu did not come out")?;
            let (shape, found) = found.into_shape_vec::<f32, 2>().map_err(words)?;
            if shape != [count, Material::LEN] {
                return Err(format!("mu came out as {shape:?}, and {:?} is needed", [count, Material::LEN]));
            }
            mu.copy_from_slice(&found);
            Ok(())
        })
    }
}

fn view<'a>(shape: &[usize], values: &'a [f32]) -> Result<ValueOrView<'a>, String> {
    Ok(ValueView::from_shape(shape, values).map_err(words)?.into())
}

/// An error with its causes.
fn words(error: impl Error) -> String {
    let mut words = error.to_string();
    let mut cause = error.source();
    while let Some(next) = cause {
        let next_words = next.to_string();
        if !words.contains(&next_words) {
            words = format!("{words}: {next_words}");
        }
        cause = next.source();
    }
    words
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_version_named_is_the_version_locked() {
        let version = super::VERSION.strip_prefix("rten ").unwrap();
        let locked = format!("name = \"rten\"\nversion = \"{version}\"");
        assert!(include_str!("../../Cargo.lock").contains(&locked), "{locked}");
    }
}
