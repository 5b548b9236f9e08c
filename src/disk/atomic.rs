//! One file, whole or not at all: temporary name, write, sync, rename, sync the folder.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

use super::store::TEMPORARY;
use crate::base::{Error, Result};

/// A file that is being written beside its place.
#[derive(Debug)]
pub(super) struct AtomicFile {
    file: File,
    temporary: PathBuf,
    target: PathBuf,
    renamed: bool,
}

impl AtomicFile {
    /// Begins a file in a folder that is there.
    pub(super) fn create(target: &Path) -> Result<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let name = target.file_name().ok_or_else(|| Error::invalid(format!("{} names no file", target.display())))?;
        // A device or a pipe would be replaced by a file of its name.
        if fs::metadata(target).is_ok_and(|there| !there.is_file()) {
            return Err(Error::invalid(format!("{} is not a file, and nothing is put in its place", target.display())));
        }
        loop {
            let mut temporary = name.to_owned();
            let unique = NEXT.fetch_add(1, Ordering::Relaxed);
            temporary.push(format!(".{}-{unique}{TEMPORARY}", process::id()));
            let temporary = target.with_file_name(temporary);
            match OpenOptions::new().read(true).write(true).create_new(true).open(&temporary) {
                Ok(file) => return Ok(AtomicFile { file, temporary, target: target.to_owned(), renamed: false }),
                // Left by a dead process that had our id.
                Err(why) if why.kind() == io::ErrorKind::AlreadyExists => {}
                Err(why) => return Err(Error::io("create", target)(why)),
            }
        }
    }

    /// Puts the file in its place, durably. A file that is there gives way if `replace`, or else this one is refused.
    pub(super) fn commit(mut self, replace: bool) -> Result<()> {
        if !replace && fs::symlink_metadata(&self.target).is_ok() {
            let taken = io::Error::new(io::ErrorKind::AlreadyExists, "it is there already, and is written but once");
            return Err(Error::io("write", &self.target)(taken));
        }
        // IMPORTANT: bytes first, then the name, then the folder that holds the name. A rename that reaches the disk
        // before its bytes would leave a torn file under a name that is trusted.
        self.file.sync_all().map_err(Error::io("sync", &self.temporary))?;
        fs::rename(&self.temporary, &self.target).map_err(Error::io("rename a temporary file to", &self.target))?;
        self.renamed = true;
        sync_folder_of(&self.target)
    }

    /// The bytes written so far, to be changed in place.
    pub(super) fn map_mut(&self) -> Result<memmap2::MmapMut> {
        // SAFETY: the file was made by this process, under a name of its own, which only its owner has. A stranger who cuts
        // it short while it is mapped ends the process with SIGBUS, as with the files of `DirStore::open`.
        unsafe { memmap2::MmapMut::map_mut(&self.file) }.map_err(Error::io("map", &self.temporary))
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.file.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.file.flush()
    }
}

impl Seek for AtomicFile {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

impl Drop for AtomicFile {
    fn drop(&mut self) {
        if !self.renamed {
            // What cannot be removed now is swept when the run is opened again.
            fs::remove_file(&self.temporary).unwrap_or_default();
        }
    }
}

/// Makes the names in a path's folder durable.
pub(super) fn sync_folder_of(path: &Path) -> Result<()> {
    let folder = match path.parent() {
        Some(parent) if parent != Path::new("") => parent,
        _ => Path::new("."),
    };
    File::open(folder).and_then(|f| f.sync_all()).map_err(Error::io("sync", folder))
}

/// Writes one file whole or not at all, in place of what is there. Its folder must be there. What `write` writes is
/// buffered; its errors, and those of the system, leave what was there as it was.
pub fn write_atomic<W>(path: impl AsRef<Path>, write: W) -> Result<()>
where
    W: FnOnce(&mut (dyn WriteSeek + '_)) -> Result<()>,
{
    let path = path.as_ref();
    let mut out = BufWriter::new(AtomicFile::create(path)?);
    write(&mut out)?;
    out.into_inner().map_err(|e| Error::io("write", path)(e.into_error()))?.commit(true)
}

/// What formats with tables of offsets need to be written to.
pub trait WriteSeek: Write + Seek + Send {}

impl<T: Write + Seek + Send> WriteSeek for T {}
