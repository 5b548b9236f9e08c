//! What the documents promise is there: the tests that SECURITY.md names, and a notice for every crate in the binary.
#![expect(clippy::unwrap_used, clippy::panic, reason = "a test fails by panicking")]

mod security;
mod third_party;

use std::path::{Path, PathBuf};

/// The project's folder.
fn project() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// The text of a file of the project.
fn text(name: &str) -> String {
    std::fs::read_to_string(project().join(name)).unwrap_or_else(|why| panic!("{name}: {why}"))
}

/// All files of Rust in a folder and below.
fn sources(folder: &str) -> Vec<PathBuf> {
    let mut folders = vec![project().join(folder)];
    let mut found = Vec::new();
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            match entry.extension() {
                _ if entry.is_dir() => folders.push(entry),
                Some(ending) if ending == "rs" => found.push(entry),
                _ => {}
            }
        }
    }
    found
}
