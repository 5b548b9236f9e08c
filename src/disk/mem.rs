//! A store in memory, for tests.

use std::collections::BTreeMap;
use std::io::{self, Write};
use std::path::PathBuf;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

use super::names::{Committed, Naming, SCRATCH, UNMARKED, check_name};
use super::scratch::{Spool, Working};
use super::store::{Content, Sink, Store};
use crate::base::{Error, Result};

/// Files in memory; clones share them.
#[derive(Debug, Clone, Default)]
pub struct MemStore {
    files: Arc<Mutex<Files>>,
}

type Files = BTreeMap<String, Arc<[u8]>>;

impl MemStore {
    /// A store without files.
    pub fn new() -> Self {
        Self::default()
    }

    fn files(&self) -> MutexGuard<'_, Files> {
        // A map of whole files is whole even after a thread panicked with its lock.
        self.files.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

struct MemSink {
    store: MemStore,
    name: String,
    bytes: Vec<u8>,
}

impl Write for MemSink {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.bytes.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        Ok(())
    }
}

impl Sink for MemSink {
    fn commit(self: Box<Self>, naming: Naming) -> Result<Committed> {
        let mut files = self.store.files();
        if naming == Naming::FirstWins && files.contains_key(&self.name) {
            return Ok(Committed::Already);
        }
        files.insert(self.name, self.bytes.into());
        Ok(Committed::Now)
    }
}

impl Spool for MemSink {
    fn work(self: Box<Self>) -> Result<Working> {
        Ok(Working::held(&self.bytes))
    }
}

impl Store for MemStore {
    fn begin(&self, name: &str) -> Result<Box<dyn Sink>> {
        check_name(name)?;
        Ok(Box::new(MemSink { store: self.clone(), name: name.to_owned(), bytes: Vec::new() }))
    }

    fn spool(&self) -> Result<Box<dyn Spool>> {
        Ok(Box::new(MemSink { store: self.clone(), name: SCRATCH.to_owned(), bytes: Vec::new() }))
    }

    fn open(&self, name: &str) -> Result<Content> {
        check_name(name)?;
        let found = self.files().get(name).cloned().map(Content::Held);
        found.ok_or_else(|| Error::io("open", self.path(name))(io::ErrorKind::NotFound.into()))
    }

    fn size(&self, name: &str) -> Result<Option<u64>> {
        check_name(name)?;
        Ok(self.files().get(name).map(|bytes| bytes.len() as u64))
    }

    fn list(&self, folder: &str) -> Result<Vec<String>> {
        if folder.is_empty() {
            return Ok(self.files().keys().cloned().collect());
        }
        check_name(folder)?;
        let below = format!("{folder}/");
        Ok(self.files().keys().filter(|name| name.starts_with(&below)).cloned().collect())
    }

    fn rename(&self, from: &str, to: &str) -> Result<()> {
        check_name(from)?;
        check_name(to)?;
        let mut files = self.files();
        let bytes = files.remove(from);
        let bytes = bytes.ok_or_else(|| Error::io("rename", self.path(from))(io::ErrorKind::NotFound.into()))?;
        files.insert(to.to_owned(), bytes);
        Ok(())
    }

    fn remove(&self, name: &str) -> Result<()> {
        check_name(name)?;
        let removed = self.files().remove(name);
        removed.map(drop).ok_or_else(|| Error::io("remove", self.path(name))(io::ErrorKind::NotFound.into()))
    }

    fn sync(&self, _: &str) -> Result<()> {
        Ok(())
    }

    fn made(&self, name: &str) -> bool {
        name.contains(&format!(".{UNMARKED}-"))
    }

    fn sweep(&self) -> Result<Vec<String>> {
        Ok(Vec::new())
    }

    fn free(&self) -> Option<u64> {
        None
    }

    fn path(&self, name: &str) -> PathBuf {
        PathBuf::from("memory").join(name)
    }

    fn attempt(&self) -> &str {
        "none-memory"
    }
}
