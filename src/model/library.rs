//! Finding and opening an ONNX Runtime library. A process can hold one library, and keeps it to the end. Only a complete file
//! is opened, and only ONNX Runtime is kept.

use std::env;
use std::ffi::{CStr, OsStr};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, PoisonError};

use ort::environment::Environment;
use ort::logging::LogLevel;
use ort::sys::OrtApiBase;

use super::backend::Backend;
use super::elf;
use super::engine::guarded;
use crate::base::{Error, Result};

/// The environment variable that names a library.
pub(super) const VARIABLE: &str = "ORT_DYLIB_PATH";

/// The library that is wanted.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Wanted {
    /// No library: the built-in engine is wanted.
    None,
    /// One file, named by the pipeline file or the environment; it must be there.
    Named {
        /// The library's file.
        path: PathBuf,
        /// The key or the variable that names the file.
        by: &'static str,
    },
    /// Any file where libraries are installed.
    Search {
        /// Whether a library must be found.
        required: bool,
    },
}

impl Wanted {
    /// The library that the pipeline file and the environment ask for. An empty variable counts as none.
    pub(super) fn new(backend: Backend, library: Option<&Path>, variable: Option<&OsStr>) -> Wanted {
        if backend == Backend::Embedded {
            return Wanted::None;
        }
        let variable = variable.filter(|v| !v.is_empty()).map(Path::new);
        let named = library.map(|l| (l, "library")).or(variable.map(|v| (v, VARIABLE)));
        match named {
            Some((path, by)) => Wanted::Named { path: path.to_owned(), by },
            None => Wanted::Search { required: backend == Backend::OnnxRuntime },
        }
    }
}

/// An ONNX Runtime library, open.
#[derive(Clone)]
pub(super) struct Library {
    /// The library's file.
    pub(super) path: PathBuf,
    version: String,
    /// The environment of the library's sessions.
    pub(super) environment: Environment,
}

impl Library {
    /// The engine and its version, for the log and the key.
    pub(super) fn version(&self) -> String {
        format!("ONNX Runtime {}", self.version)
    }
}

/// Opens the wanted library. Returns the library, if any, and a note for the log on libraries that were passed over.
///
/// # Errors
/// A named or required library that cannot be used.
pub(super) fn open(wanted: &Wanted) -> Result<(Option<Library>, Option<String>)> {
    let needed = format!("needed: the shared library of ONNX Runtime 1.{} or newer", ort::MINOR_VERSION);
    match wanted {
        Wanted::None => Ok((None, None)),
        Wanted::Named { path, by } => match open_file(path) {
            Ok(library) => Ok((Some(library), None)),
            Err(why) => Err(Error::malformed(path, format!("named by {by}, but {why}; {needed}"))),
        },
        Wanted::Search { required } => {
            let mut faults = Vec::new();
            for path in folders().iter().flat_map(|f| names().map(|n| f.join(n))).filter(|p| p.exists()) {
                match open_file(&path) {
                    Ok(library) => return Ok((Some(library), None)),
                    Err(why) => faults.push(format!("{} was not used: {why}", path.display())),
                }
            }
            if *required {
                let looked: Vec<String> = folders().iter().map(|f| f.display().to_string()).collect();
                faults.insert(0, format!("no usable ONNX Runtime library in {}", looked.join(", ")));
                let advice = "name one by library or ORT_DYLIB_PATH, or set backend = \"embedded\"";
                return Err(Error::invalid(format!("{}; {needed}; {advice}", faults.join("; "))));
            }
            Ok((None, (!faults.is_empty()).then(|| faults.join("; "))))
        }
    }
}

/// The folders where a library may be installed, nearest first.
fn folders() -> Vec<PathBuf> {
    let beside = env::current_exe().ok().and_then(|exe| exe.parent().map(Path::to_owned));
    let listed = env::var_os("LD_LIBRARY_PATH").unwrap_or_default();
    let listed = env::split_paths(&listed).filter(|p| p.is_absolute()).collect::<Vec<_>>();
    let multiarch = format!("/usr/lib/{}-linux-gnu", env::consts::ARCH);
    let system = ["/usr/local/lib", "/usr/lib", "/usr/lib64"].map(PathBuf::from);
    beside.into_iter().chain(listed).chain(system).chain([multiarch.into()]).collect()
}

fn names() -> impl Iterator<Item = String> {
    let plain = format!("{}onnxruntime{}", env::consts::DLL_PREFIX, env::consts::DLL_SUFFIX);
    [plain.clone(), format!("{plain}.1")].into_iter()
}

/// The library that this process holds. The second part is missing if the library was opened but did not start.
static HELD: Mutex<Option<(PathBuf, Option<Library>)>> = Mutex::new(None);

fn open_file(path: &Path) -> Result<Library, String> {
    let path = path.canonicalize().map_err(|e| e.to_string())?;
    let mut held = HELD.lock().unwrap_or_else(PoisonError::into_inner);
    match &*held {
        Some((holds, Some(library))) if *holds == path => return Ok(library.clone()),
        Some((holds, _)) if *holds == path => return Err("it did not start before".into()),
        Some((holds, _)) => {
            return Err(format!("this process already holds {}, and can hold one only", holds.display()));
        }
        None => {}
    }
    elf::complete(&path)?;
    let version = version(&path)?;
    let builder = guarded(|| ort::init_from(&path).map_err(|e| e.to_string()))?;
    *held = Some((path.clone(), None));
    let start = || builder.with_name("gonio").with_telemetry(false).build().map_err(|e| e.to_string());
    let environment = guarded(start)?;
    // The library would repeat its errors on stderr.
    environment.set_log_level(LogLevel::Fatal);
    let library = Library { path: path.clone(), version, environment };
    *held = Some((path, Some(library.clone())));
    Ok(library)
}

/// The version that a library reports, if the library is ONNX Runtime and new enough.
fn version(path: &Path) -> Result<String, String> {
    // SAFETY: opening a library runs its initialisers, as the user who named it wants; the file is complete.
    let library = unsafe { libloading::Library::new(path) }.map_err(|e| {
        let cause = std::error::Error::source(&e).map_or_else(|| e.to_string(), ToString::to_string);
        format!("the system cannot open it: {cause}")
    })?;
    // SAFETY: the type is that of ONNX Runtime's C API, which has had this one entry point since 1.0.
    let entry = unsafe { library.get::<unsafe extern "system" fn() -> *const OrtApiBase>(b"OrtGetApiBase\0") }
        .map_err(|_| "it is not ONNX Runtime: it has no OrtGetApiBase".to_owned())?;
    // SAFETY: the entry point takes no argument and returns null or a static table. The version is a static string that
    // ends in a zero byte.
    let (version, serves) = unsafe {
        let base = entry().as_ref().ok_or("its OrtGetApiBase returns nothing")?;
        let version = CStr::from_ptr((base.GetVersionString)()).to_string_lossy().into_owned();
        (version, !(base.GetApi)(ort::MINOR_VERSION).is_null())
    };
    if !serves {
        return Err(format!("it is ONNX Runtime {version}, which is too old"));
    }
    Ok(version)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_named_library_is_used_and_others_are_searched() {
        let (library, variable) = (Some(Path::new("/a")), Some(OsStr::new("/b")));
        let named = |path: &str, by| Wanted::Named { path: path.into(), by };
        for (backend, library, variable, wanted) in [
            (Backend::Embedded, library, variable, Wanted::None),
            (Backend::Auto, library, variable, named("/a", "library")),
            (Backend::Auto, None, variable, named("/b", VARIABLE)),
            (Backend::OnnxRuntime, None, variable, named("/b", VARIABLE)),
            (Backend::Auto, None, Some(OsStr::new("")), Wanted::Search { required: false }),
            (Backend::OnnxRuntime, None, None, Wanted::Search { required: true }),
        ] {
            assert_eq!(Wanted::new(backend, library, variable), wanted);
        }
    }
}
