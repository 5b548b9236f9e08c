//! Input files that fail, for tests: at the n-th open or read below a folder. Tests run side by side, so faults belong to a
//! folder and to nobody else's files.

use std::fs;
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::atomic::{AtomicU64, Ordering};
use std::sync::{Arc, Mutex, MutexGuard, PoisonError};

/// The fault at a call.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) enum Fault {
    /// The call fails with this error of the system, by its number.
    Refused(i32),
    /// A read gives one byte. An open goes well.
    Short,
    /// The file loses its second half before the call.
    Cut,
    /// The file gets more bytes before the call.
    Grown,
    /// Another file has the name before the call: that of the next file in the folder, by name.
    Exchanged,
    /// The file's bytes are turned round before the call, in place.
    Overwritten,
    /// The file is gone before the call.
    Gone,
}

/// Calls that fail below a folder, as long as this lives.
#[derive(Debug)]
pub(crate) struct FaultyInput(Arc<Plan>);

#[derive(Debug)]
struct Plan {
    folder: PathBuf,
    faults: Vec<(u64, Fault)>,
    calls: AtomicU64,
}

static PLANS: Mutex<Vec<Arc<Plan>>> = Mutex::new(Vec::new());

fn plans() -> MutexGuard<'static, Vec<Arc<Plan>>> {
    PLANS.lock().unwrap_or_else(PoisonError::into_inner)
}

impl FaultyInput {
    /// Fails at these calls, counted from 0, below a folder.
    pub(crate) fn below(folder: &Path, faults: Vec<(u64, Fault)>) -> Self {
        let plan = Arc::new(Plan { folder: folder.to_owned(), faults, calls: AtomicU64::new(0) });
        plans().push(Arc::clone(&plan));
        FaultyInput(plan)
    }

    /// The calls so far.
    pub(crate) fn calls(&self) -> u64 {
        self.0.calls.load(Ordering::SeqCst)
    }
}

impl Drop for FaultyInput {
    fn drop(&mut self) {
        plans().retain(|plan| !Arc::ptr_eq(plan, &self.0));
    }
}

/// Counts a call on a file, and does what fails at it. Gives the fault where the caller has to do it.
pub(super) fn step(path: &Path) -> io::Result<Option<Fault>> {
    let plan = plans().iter().find(|plan| path.starts_with(&plan.folder)).cloned();
    let Some(plan) = plan else { return Ok(None) };
    let call = plan.calls.fetch_add(1, Ordering::SeqCst);
    let Some((_, fault)) = plan.faults.iter().find(|(at, _)| *at == call) else { return Ok(None) };
    match fault {
        Fault::Refused(errno) => return Err(io::Error::from_raw_os_error(*errno)),
        Fault::Short => {}
        // A file that an earlier fault took away stays away.
        fault => change(path, *fault).unwrap_or_default(),
    }
    Ok(Some(*fault))
}

fn change(path: &Path, fault: Fault) -> io::Result<()> {
    match fault {
        Fault::Refused(_) | Fault::Short => Ok(()),
        Fault::Cut => {
            let file = fs::File::options().write(true).open(path)?;
            file.set_len(file.metadata()?.len() / 2)
        }
        Fault::Grown => fs::File::options().append(true).open(path)?.write_all(b"more"),
        Fault::Exchanged => {
            let mut others: Vec<PathBuf> =
                fs::read_dir(path.parent().unwrap_or(path))?.flatten().map(|entry| entry.path()).collect();
            others.retain(|other| other.extension() == path.extension());
            others.sort();
            let next = others.iter().find(|other| other.as_path() > path).or(others.first());
            let copy = path.with_extension("copy");
            fs::copy(next.map_or(path, PathBuf::as_path), &copy)?;
            fs::rename(copy, path)
        }
        Fault::Overwritten => {
            let mut bytes = fs::read(path)?;
            bytes.reverse();
            fs::write(path, bytes)
        }
        Fault::Gone => fs::remove_file(path),
    }
}
