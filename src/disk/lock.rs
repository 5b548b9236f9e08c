//! One run per folder. The system locks an open file, so the lock ends when its process ends, however that happens; the
//! process id in the file is for people. The file stays: if it were removed, two runs could lock two files.

use std::fs::{File, OpenOptions, TryLockError};
use std::io::{Read, Seek, Write};
use std::path::Path;

use super::mark;
use crate::base::{Error, Result};

/// The name of the lock's file in the run's folder.
pub(crate) const LOCK: &str = "lock";

/// Keeps other runs out of a folder for as long as it lives.
#[derive(Debug)]
#[must_use = "the folder is locked only while this lives"]
pub struct Lock {
    file: File,
}

impl Lock {
    /// Locks a folder. A folder that is not there is made; a folder that is empty becomes a run's.
    ///
    /// # Errors
    /// `Error::Invalid`: another process has the lock, and is named, or the folder holds files of others, and some are named.
    pub fn acquire(folder: impl AsRef<Path>) -> Result<Lock> {
        let folder = folder.as_ref();
        mark::take(folder)?;
        let path = folder.join(LOCK);
        let file = OpenOptions::new()
            .read(true)
            .write(true)
            .create(true)
            .truncate(false)
            .open(&path)
            .map_err(Error::io("open", &path))?;
        match file.try_lock() {
            Ok(()) => {}
            Err(TryLockError::WouldBlock) => {
                let mut text = String::new();
                // The holder may not have written its id yet, and the file may hold anything.
                (&file).take(20).read_to_string(&mut text).unwrap_or_default();
                let who =
                    text.trim().parse::<u32>().map_or("another process".to_owned(), |pid| format!("process {pid}"));
                return Err(Error::invalid(format!(
                    "{} is in use by {who}: wait until it ends, or give this run another `[run] work`",
                    folder.display()
                )));
            }
            Err(TryLockError::Error(why)) => return Err(Error::io("lock", &path)(why)),
        }
        let mut lock = Lock { file };
        lock.sign().map_err(Error::io("write", &path))?;
        Ok(lock)
    }

    fn sign(&mut self) -> std::io::Result<()> {
        self.file.set_len(0)?;
        self.file.rewind()?;
        writeln!(self.file, "{}", std::process::id())
    }
}
