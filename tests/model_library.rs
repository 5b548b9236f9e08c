//! Libraries that are not what they should be. A process holds one library for good, so these run apart from the tests
//! that use one, and none of them may open.
#![expect(clippy::panic, reason = "a test fails by panicking, and says what it skips")]

use std::path::{Path, PathBuf};

use gonio::model::{self, Backend, ModelSource};

fn refusal(backend: Backend, library: &Path) -> String {
    let source = ModelSource::named(model::BUILT_IN[0].name, Path::new(""));
    let loaded = model::load(&source, backend, Some(library));
    let said = loaded.err().unwrap_or_else(|| panic!("{} was accepted", library.display())).to_string();
    assert!(said.contains(&*library.to_string_lossy()), "{said}");
    assert!(said.contains("needed: the shared library of ONNX Runtime 1.17 or newer"), "{said}");
    said
}

/// A shared library of this system: the C library that this very process uses.
#[cfg(target_os = "linux")]
fn system_library() -> Option<PathBuf> {
    let maps = std::fs::read_to_string("/proc/self/maps").ok()?;
    maps.split_whitespace().find(|w| w.starts_with('/') && w.contains("libc.so")).map(PathBuf::from)
}

#[test]
fn what_is_no_library_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let text = folder.path().join("libonnxruntime.so");
    std::fs::write(&text, "not a library\n").unwrap();
    let empty = folder.path().join("empty.so");
    std::fs::write(&empty, "").unwrap();
    for backend in [Backend::Auto, Backend::OnnxRuntime] {
        assert!(refusal(backend, &folder.path().join("none.so")).contains("No such file"));
        assert!(refusal(backend, folder.path()).contains("it is no file"));
        assert!(refusal(backend, &text).contains("the system cannot open it"));
        assert!(refusal(backend, &empty).contains("the system cannot open it"));
    }
}

#[test]
fn the_embedded_engine_asks_for_no_library() {
    let source = ModelSource::named(model::BUILT_IN[0].name, Path::new(""));
    let model = model::load(&source, Backend::Embedded, Some(Path::new("/nowhere/none.so"))).unwrap();
    assert!(model.describe().ends_with("tract 0.23.9, built in"), "{}", model.describe());
}

#[cfg(target_os = "linux")]
#[test]
fn another_library_is_refused() {
    let Some(library) = system_library() else { return println!("skipped: no C library found") };
    let said = refusal(Backend::Auto, &library);
    assert!(said.contains("it is not ONNX Runtime: it has no OrtGetApiBase"), "{said}");
}

/// The system's loader would kill the process.
#[cfg(target_os = "linux")]
#[test]
fn a_library_cut_short_is_refused() {
    let Some(library) = system_library() else { return println!("skipped: no C library found") };
    let whole = std::fs::read(library).unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("cut.so");
    let lengths = [16, 63, 64, 100, 500, 4096, whole.len() / 4, whole.len() / 2, whole.len() - 4096, whole.len() - 1];
    for length in lengths {
        std::fs::write(&path, &whole[..length]).unwrap();
        let said = refusal(Backend::OnnxRuntime, &path);
        assert!(said.contains("it is cut short") || length < 64, "{length}: {said}");
    }
}
