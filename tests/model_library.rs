//! Libraries that are not what they should be. A process holds one library for good, so these run apart from the tests
//! that use one, and none of them may open.
#![expect(clippy::panic, clippy::unwrap_used, reason = "a test fails by panicking, and says what it skips")]

use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::Duration;

use gonio::internals::model::{self, Backend, ModelSource};

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
        assert!(refusal(backend, folder.path()).contains("it is a folder, not a file"));
        assert!(refusal(backend, &text).contains("the system cannot open it"));
        assert!(refusal(backend, &empty).contains("the system cannot open it"));
    }
}

#[test]
fn the_embedded_engine_asks_for_no_library() {
    let source = ModelSource::named(model::BUILT_IN[0].name, Path::new(""));
    let model = model::load(&source, Backend::Embedded, Some(Path::new("/nowhere/none.so"))).unwrap();
    assert!(model.describe().ends_with("rten 0.27.0, built in"), "{}", model.describe());
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

/// Says what was loaded, or why nothing was; the tests below run it in other environments.
#[test]
#[ignore = "run by the tests below"]
fn say_what_is_loaded() {
    let backend = std::env::var("BACKEND_UNDER_TEST").unwrap_or_default().parse().unwrap_or_default();
    let source = ModelSource::named(model::BUILT_IN[0].name, Path::new(""));
    match model::load(&source, backend, None) {
        Ok(model) => {
            println!("loaded: {}", model.describe());
            let sessions = [model.session().unwrap(), model.session().unwrap()];
            // Threads take their names, and end, a moment after they are told to.
            (0..200).take_while(|_| engine_threads() != 4).for_each(|_| std::thread::sleep(Duration::from_millis(10)));
            println!("threads of the engine: {}", engine_threads());
            drop(sessions);
        }
        Err(e) => println!("refused: {e}"),
    }
}

/// The number of this process's threads that belong to the built-in engine.
fn engine_threads() -> usize {
    let threads = std::fs::read_dir("/proc/self/task").into_iter().flatten().flatten();
    let names = threads.filter_map(|t| std::fs::read_to_string(t.path().join("comm")).ok());
    names.filter(|name| name.starts_with("rten")).count()
}

/// What a process says that finds these values of `ORT_DYLIB_PATH` and `LD_LIBRARY_PATH`.
fn said_with(backend: Backend, library: &Path, folder: &Path) -> String {
    let output = Command::new(std::env::current_exe().unwrap())
        .args(["--exact", "say_what_is_loaded", "--ignored", "--nocapture"])
        .env("BACKEND_UNDER_TEST", backend.to_string())
        .env("ORT_DYLIB_PATH", library)
        .env("LD_LIBRARY_PATH", folder)
        .env("RTEN_NUM_THREADS", "1")
        .env("RAYON_NUM_THREADS", "999999")
        .output()
        .unwrap();
    assert!(output.status.success(), "{output:?}");
    String::from_utf8_lossy(&output.stdout).into_owned()
}

#[cfg(target_os = "linux")]
#[test]
fn the_embedded_engine_has_one_thread_a_session() {
    let said = said_with(Backend::Embedded, Path::new(""), Path::new(""));
    // Two sessions, the thread that the model was loaded on, and one that the process keeps.
    assert!(said.contains("threads of the engine: 4\n"), "{said}");
}

#[test]
fn a_library_that_the_environment_names_must_work() {
    let none = Path::new("/nowhere/none.so");
    for backend in [Backend::Auto, Backend::OnnxRuntime] {
        let said = said_with(backend, none, Path::new(""));
        assert!(said.contains("refused: /nowhere/none.so: named by ORT_DYLIB_PATH, but No such file"), "{said}");
    }
    let said = said_with(Backend::Embedded, none, Path::new(""));
    assert!(said.contains("built in"), "{said}");
}

#[test]
fn auto_passes_over_a_broken_library_that_nobody_named() {
    let folder = tempfile::tempdir().unwrap();
    let name = format!("{}onnxruntime{}", std::env::consts::DLL_PREFIX, std::env::consts::DLL_SUFFIX);
    std::fs::write(folder.path().join(&name), "not a library\n").unwrap();
    let said = said_with(Backend::Auto, Path::new(""), folder.path());
    let passed_over = said.contains("built in; ") && said.contains(&format!("{name} was not used: the system cannot"));
    let found_another = said.contains("on ONNX Runtime");
    assert!(passed_over || found_another, "{said}");
    let said = said_with(Backend::OnnxRuntime, Path::new(""), folder.path());
    let refused =
        said.contains("refused: no usable ONNX Runtime library in") && said.contains("backend = \"embedded\"");
    assert!(refused || found_another, "{said}");
}
