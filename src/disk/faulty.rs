//! A store that fails at its n-th step, for tests. A step is a write, a sync, a naming, a renaming or a removal.

use std::io::{self, ErrorKind, Write};
use std::path::PathBuf;
use std::sync::Arc;
use std::sync::atomic::{AtomicBool, AtomicU64, Ordering};

use super::names::{Committed, Naming, SCRATCH};
use super::scratch::{Spool, Working};
use super::store::{Content, Sink, Store};
use crate::base::{Error, Result};

/// The fault at the step.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// The step fails with this error; the program lives on and cleans up.
    Refused(ErrorKind),
    /// The process ends before the step: it does nothing from then on, and cleans up nothing.
    Killed,
    /// The process ends in the middle of the step: after half the bytes of a write, or after a naming of which nobody is
    /// told.
    Torn,
}

/// A store over another one, which fails once.
#[derive(Debug, Clone)]
pub(crate) struct FaultyStore {
    inner: Arc<dyn Store>,
    state: Arc<State>,
    /// A file that reads wrong, however often it is written.
    rotten: Option<String>,
    /// The bytes that the store says are free.
    free: Option<u64>,
}

#[derive(Debug)]
struct State {
    at: u64,
    fault: Fault,
    steps: AtomicU64,
    dead: AtomicBool,
}

impl State {
    /// Counts a step: the fault if this is its step; an error if the process has ended.
    fn step(&self) -> io::Result<Option<Fault>> {
        if self.dead.load(Ordering::SeqCst) {
            return Err(gone());
        }
        let found = self.steps.fetch_add(1, Ordering::SeqCst) == self.at;
        self.dead.fetch_or(found && matches!(self.fault, Fault::Killed | Fault::Torn), Ordering::SeqCst);
        Ok(found.then_some(self.fault))
    }
}

impl FaultyStore {
    /// Fails at step `at`, counted from 0.
    pub(crate) fn new(inner: Arc<dyn Store>, at: u64, fault: Fault) -> Self {
        let state = State { at, fault, steps: AtomicU64::new(0), dead: AtomicBool::new(false) };
        FaultyStore { inner, state: Arc::new(state), rotten: None, free: None }
    }

    /// Never fails, but this file reads wrong, however often it is written.
    pub(crate) fn rotten(inner: Arc<dyn Store>, name: &str) -> Self {
        FaultyStore { rotten: Some(name.to_owned()), ..FaultyStore::new(inner, u64::MAX, Fault::Killed) }
    }

    /// Never fails, but says that only these bytes are free.
    pub(crate) fn narrow(inner: Arc<dyn Store>, free: u64) -> Self {
        FaultyStore { free: Some(free), ..FaultyStore::new(inner, u64::MAX, Fault::Killed) }
    }

    /// The number of steps so far.
    pub(crate) fn steps(&self) -> u64 {
        self.state.steps.load(Ordering::SeqCst)
    }

    /// Does one step, or the part of it that the fault leaves.
    fn step<T>(&self, path: &str, done: impl FnOnce() -> Result<T>) -> Result<T> {
        let failed = |why: io::Error| Error::io("change", self.inner.path(path))(why);
        match self.state.step().map_err(failed)? {
            None => done(),
            Some(Fault::Refused(kind)) => Err(failed(kind.into())),
            Some(Fault::Killed) => Err(failed(gone())),
            Some(Fault::Torn) => done().and(Err(failed(gone()))),
        }
    }
}

fn gone() -> io::Error {
    io::Error::other("the process is gone")
}

struct FaultySink<S: ?Sized> {
    inner: Option<Box<S>>,
    store: FaultyStore,
    name: String,
}

impl<S: Write + ?Sized> Write for FaultySink<S> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let inner = self.inner.as_mut().ok_or_else(gone)?;
        match self.store.state.step()? {
            None => inner.write(bytes),
            Some(Fault::Refused(kind)) => Err(kind.into()),
            Some(Fault::Killed) => Err(gone()),
            Some(Fault::Torn) => inner.write_all(&bytes[..bytes.len() / 2]).and(Err(gone())),
        }
    }

    fn flush(&mut self) -> io::Result<()> {
        self.inner.as_mut().ok_or_else(gone)?.flush()
    }
}

impl Sink for FaultySink<dyn Sink> {
    fn commit(mut self: Box<Self>, naming: Naming) -> Result<Committed> {
        // The sync of the bytes, the naming, the sync of the folder: a fault before the naming leaves no name.
        let (store, name) = (self.store.clone(), self.name.clone());
        store.step(&name, || Ok(()))?;
        let committed = store
            .step(&name, || self.inner.take().map_or(Err(Error::invalid("no sink")), |sink| sink.commit(naming)))?;
        store.step(&name, || Ok(()))?;
        Ok(committed)
    }
}

impl Spool for FaultySink<dyn Spool> {
    fn work(mut self: Box<Self>) -> Result<Working> {
        self.inner.take().map_or(Err(Error::invalid("no spool")), |spool| spool.work())
    }
}

impl<S: ?Sized> Drop for FaultySink<S> {
    fn drop(&mut self) {
        if self.store.state.dead.load(Ordering::SeqCst) {
            // A process that has ended does not clean up.
            std::mem::forget(self.inner.take());
        }
    }
}

impl Store for FaultyStore {
    fn begin(&self, name: &str) -> Result<Box<dyn Sink>> {
        let inner = Some(self.inner.begin(name)?);
        Ok(Box::new(FaultySink { inner, store: self.clone(), name: name.to_owned() }))
    }

    fn spool(&self) -> Result<Box<dyn Spool>> {
        let inner = Some(self.inner.spool()?);
        Ok(Box::new(FaultySink { inner, store: self.clone(), name: SCRATCH.to_owned() }))
    }

    fn open(&self, name: &str) -> Result<Content> {
        let content = self.inner.open(name)?;
        if self.rotten.as_deref() != Some(name) {
            return Ok(content);
        }
        let mut bytes = content.to_vec();
        let middle = bytes.len() / 3;
        bytes[middle] ^= 4;
        Ok(Content::Held(bytes.into()))
    }

    fn size(&self, name: &str) -> Result<Option<u64>> {
        self.inner.size(name)
    }

    fn is_obstructed(&self, name: &str) -> Result<bool> {
        self.inner.is_obstructed(name)
    }

    fn obstacles(&self, folder: &str) -> Result<Vec<String>> {
        self.inner.obstacles(folder)
    }

    fn list(&self, folder: &str) -> Result<Vec<String>> {
        self.inner.list(folder)
    }

    fn rename(&self, from: &str, to: &str) -> Result<()> {
        self.step(from, || self.inner.rename(from, to))
    }

    fn remove(&self, name: &str) -> Result<()> {
        self.step(name, || self.inner.remove(name))
    }

    fn sync(&self, folder: &str) -> Result<()> {
        self.step(folder, || self.inner.sync(folder))
    }

    fn made(&self, name: &str) -> bool {
        self.inner.made(name)
    }

    fn sweep(&self) -> Result<Vec<String>> {
        self.inner.sweep()
    }

    fn free(&self) -> Option<u64> {
        self.free.or_else(|| self.inner.free())
    }

    fn path(&self, name: &str) -> PathBuf {
        self.inner.path(name)
    }
    fn attempt(&self) -> &str {
        self.inner.attempt()
    }
}
