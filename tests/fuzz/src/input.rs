//! Inputs as readers meet them: files in a folder, files in a store, files under a seal that fits.

use std::fs;
use std::io::Write;
use std::path::PathBuf;
use std::sync::LazyLock;

use gonio::internals::disk::{MemStore, Store};
use tempfile::TempDir;

static FOLDER: LazyLock<TempDir> = LazyLock::new(|| TempDir::new().unwrap());

/// The folder of all files.
pub fn folder() -> PathBuf {
    FOLDER.path().to_owned()
}

/// The path of a file with these bytes.
pub fn file(name: &str, bytes: &[u8]) -> PathBuf {
    let path = FOLDER.path().join(name);
    fs::write(&path, bytes).unwrap();
    path
}

/// Puts a file with these bytes into a store.
pub fn put(store: &MemStore, name: &str, bytes: &[u8]) {
    let mut draft = store.create(name).unwrap();
    draft.write_all(bytes).unwrap();
    draft.replace().unwrap();
}

/// A sealed file with this body (`disk::sealed`).
pub fn sealed(body: &[u8], version: u32, magic: &[u8; 8]) -> Vec<u8> {
    let mut all = body.to_vec();
    all.extend((body.len() as u64).to_le_bytes());
    all.extend(version.to_le_bytes());
    all.extend(crc32fast::hash(body).to_le_bytes());
    all.extend(magic);
    all
}

/// The kind of an input, its first byte, and the rest.
pub fn kind(bytes: &[u8], kinds: u8) -> Option<(u8, &[u8])> {
    bytes.split_first().map(|(first, rest)| (first % kinds, rest))
}
