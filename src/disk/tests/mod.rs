//! One suite of plain functions for every store, then files that are mangled by hand and opened again.

use std::io::Write;
use std::sync::Arc;

use super::{DirStore, FileEntry, MemStore, Store};

mod atomic;
mod faults;
mod frozen;
mod ledger;
#[cfg(unix)]
mod links;
mod lock;
mod mark;
mod race;
mod sealed;
mod store;

/// Runs a test on every kind of store.
fn on_each_store(test: impl Fn(Arc<dyn Store>)) {
    test(Arc::new(MemStore::new()));
    let folder = tempfile::tempdir().unwrap();
    test(Arc::new(DirStore::new(folder.path().join("work"))));
}

/// Commits a file.
fn put(store: &dyn Store, name: &str, bytes: &[u8]) -> FileEntry {
    let mut draft = store.create(name).unwrap();
    draft.write_all(bytes).unwrap();
    draft.commit().unwrap()
}

/// Puts other bytes in a file's place, as only a fault does.
fn mangle(store: &dyn Store, name: &str, bytes: &[u8]) {
    let mut draft = store.create(name).unwrap();
    draft.write_all(bytes).unwrap();
    draft.replace().unwrap();
}
