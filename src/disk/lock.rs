//! One run per folder. The system locks an open file, so the lock ends when its process ends, however that happens; the
//! process id in the file is for people. The file stays: if it were removed, two runs could lock two files.

use std::fs::{File, TryLockError};
use std::io::{Read, Seek, Write};

use super::dir::DirStore;
#[cfg(all(test, unix))]
use super::journal::Step;
use super::mark;
use crate::base::{Error, Result};

/// The name of the lock's file in the run's folder.
pub(crate) const LOCK: &str = "lock";

/// The most bytes of a lock's file: a process id and the end of its line.
const LONGEST: u64 = 20;

/// Keeps other runs out of a folder for as long as it lives.
#[derive(Debug)]
#[must_use = "the folder is locked only while this lives"]
pub struct Lock {
    file: File,
}

impl Lock {
    /// Locks a store's folder. A folder that is not there is made; a folder that is empty becomes a run's.
    ///
    /// # Errors
    /// `Error::Invalid`: another process has the lock, and is named, or the folder holds files of others, and some are named.
    pub fn acquire(store: &DirStore) -> Result<Lock> {
        let folder = store.made_folder()?;
        mark::take(&folder, store.root())?;
        // IMPORTANT: before the first change, which builds on what is there.
        store.settle(&folder)?;
        let path = store.root().join(LOCK);
        let file = folder.open_or_create(LOCK).map_err(Error::io("open", &path))?;
        let mut said = String::new();
        let read = (&file).take(LONGEST + 1).read_to_string(&mut said).map(drop);
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                // The holder may not have written its id yet, and the file may hold anything.
                let who =
                    said.trim().parse::<u32>().map_or("another process".to_owned(), |pid| format!("process {pid}"));
                return Err(Error::invalid(format!(
                    "{} is in use by {who}: wait until it ends, or give this run another `[run] work`",
                    store.root().display()
                )));
            }
            Err(TryLockError::Error(why)) => return Err(Error::io("lock", &path)(why)),
        }
        #[cfg(all(test, unix))]
        let noted = folder.note(|at| Step::Rewrite(at.join(LOCK), format!("{}\n", std::process::id()).into()));
        #[cfg(all(test, unix))]
        let _noted = noted.map_err(Error::io("write", &path))?;
        let mut lock = Lock { file };
        // What no lock wrote is somebody's, by a hard link perhaps: the file locks as well with that in it.
        if read.is_ok() && (said.is_empty() || said.trim_end().parse::<u32>().is_ok()) {
            lock.sign().map_err(Error::io("write", &path))?;
        }
        Ok(lock)
    }

    fn sign(&mut self) -> std::io::Result<()> {
        self.file.set_len(0)?;
        self.file.rewind()?;
        writeln!(self.file, "{}", std::process::id())
    }
}
