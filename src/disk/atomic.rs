//! One file, whole or not at all: temporary name, write, sync, final name, sync the folder.

use std::fs::File;
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};

use super::folder::{Folder, Kind, has_no_links};
#[cfg(all(test, unix))]
use super::journal::Step;
use super::names::{Committed, Naming, TEMPORARY};
use crate::base::{Error, Result};

/// A file that is being written beside its place.
#[derive(Debug)]
pub(super) struct AtomicFile {
    file: File,
    folder: Arc<Folder>,
    temporary: PathBuf,
    name: PathBuf,
    /// The file in messages.
    path: PathBuf,
    /// Whether the temporary name is gone.
    renamed: bool,
}

impl AtomicFile {
    /// Begins a file in this folder, which is at `path` but for the file's name. Its temporary name carries `mark`.
    pub(super) fn create(folder: Arc<Folder>, path: &Path, mark: &str) -> Result<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let name = path.file_name().ok_or_else(|| Error::invalid(format!("{} names no file", path.display())))?;
        let (name, path) = (PathBuf::from(name), path.to_owned());
        refuse_strange(&folder, &name, &path)?;
        loop {
            let mut temporary = name.clone().into_os_string();
            let unique = NEXT.fetch_add(1, Ordering::Relaxed);
            temporary.push(format!(".{mark}{}-{unique}{TEMPORARY}", process::id()));
            let temporary = PathBuf::from(temporary);
            match folder.create_new(&temporary) {
                Ok(file) => return Ok(AtomicFile { file, folder, temporary, name, path, renamed: false }),
                // A dead process with our id left it, or a process of another machine has our id.
                Err(why) if why.kind() == io::ErrorKind::AlreadyExists => {}
                Err(why) => return Err(Error::io("create", path)(why)),
            }
        }
    }

    /// Gives the file its name, durably, unless another file has the name and `naming` lets it stay.
    pub(super) fn commit(mut self, naming: Naming) -> Result<Committed> {
        // IMPORTANT: bytes first, then the name, then the folder that holds the name. A name that reaches the disk
        // before its bytes would leave a torn file that is trusted.
        self.sync().map_err(Error::io("sync", &self.path))?;
        match naming {
            Naming::Replace => {
                refuse_strange(&self.folder, &self.name, &self.path)?;
                self.folder
                    .rename(&self.temporary, &self.folder, &self.name)
                    .map_err(Error::io("rename a temporary file to", &self.path))?;
                self.renamed = true;
            }
            Naming::FirstWins => {
                if self.take_name(|folder, from, to| folder.link(from, to))? == Committed::Already {
                    return Ok(Committed::Already);
                }
            }
        }
        self.folder.sync().map_err(Error::io("sync the folder of", &self.path))?;
        Ok(Committed::Now)
    }

    fn sync(&self) -> io::Result<()> {
        #[cfg(all(test, unix))]
        if self.folder.note(|at| Step::SyncFile(at.join(&self.temporary)))?.is_some() {
            return Ok(());
        }
        self.file.sync_all()
    }

    /// Takes the name if it is free, in one step of the filesystem: two processes cannot both take it. `link` makes a
    /// hard link; where there are none, the file is renamed without replacing another.
    fn take_name(&mut self, link: impl FnOnce(&Folder, &Path, &Path) -> io::Result<()>) -> Result<Committed> {
        let taken = match link(&self.folder, &self.temporary, &self.name) {
            Ok(()) => {
                // What cannot be removed now is swept with the other temporary files.
                self.renamed = self.folder.remove(&self.temporary).is_ok();
                Ok(())
            }
            Err(why) if has_no_links(&why) => {
                let renamed = self.folder.rename_new(&self.temporary, &self.name);
                self.renamed = renamed.is_ok();
                renamed
            }
            Err(why) => Err(why),
        };
        match taken {
            Ok(()) => Ok(Committed::Now),
            // NOTE: a network filesystem may do the link, lose its answer, and answer the second request with "exists".
            Err(why) if why.kind() == io::ErrorKind::AlreadyExists => {
                let own = self.folder.is_named(&self.file, &self.name);
                Ok(if own { Committed::Now } else { Committed::Already })
            }
            Err(why) => Err(Error::io("name a temporary file", &self.path)(why)),
        }
    }

    /// The bytes written so far, to be changed in place.
    pub(super) fn map_mut(&self) -> Result<memmap2::MmapMut> {
        // SAFETY: this process made the file, under a name of its own that only the file's owner has. A stranger who cuts
        // the file short while it is mapped ends the process with SIGBUS, as with the files of `DirStore::open`.
        unsafe { memmap2::MmapMut::map_mut(&self.file) }.map_err(Error::io("map", &self.path))
    }
}

/// Refuses a name that something other than a file has: a link, a device or a pipe would be replaced by the file.
fn refuse_strange(folder: &Folder, name: &Path, path: &Path) -> Result<()> {
    match folder.kind(name).map_err(Error::io("look at", path))? {
        None | Some(Kind::File) => Ok(()),
        Some(Kind::Folder | Kind::Other) => Err(Error::invalid(format!(
            "{} is not a file but a link, a folder or a device, so no file is put in its place: name another file",
            path.display()
        ))),
    }
}

impl Write for AtomicFile {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        #[cfg(all(test, unix))]
        let at = self.file.stream_position()?;
        #[cfg(all(test, unix))]
        let _noted = self.folder.note(|above| Step::Write(above.join(&self.temporary), at, bytes.to_vec()))?;
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
            self.folder.remove(&self.temporary).unwrap_or_default();
        }
    }
}

/// Writes one file whole or not at all, in place of the file that is there. The folder must be there. What `write`
/// writes is buffered; an error of `write` or of the system leaves the old file as it was.
pub(crate) fn write_atomic<W>(path: impl AsRef<Path>, write: W) -> Result<()>
where
    W: FnOnce(&mut (dyn WriteSeek + '_)) -> Result<()>,
{
    let path = path.as_ref();
    let above = path.parent().unwrap_or(Path::new(""));
    let folder = Folder::open(above).map_err(Error::io("open the folder of", path))?;
    let mut out = BufWriter::new(AtomicFile::create(Arc::new(folder), path, "")?);
    write(&mut out)?;
    let file = out.into_inner().map_err(|e| Error::io("write", path)(e.into_error()))?;
    file.commit(Naming::Replace).map(|_| ())
}

/// The output of formats that write tables of offsets last.
pub(crate) trait WriteSeek: Write + Seek + Send {}

impl<T: Write + Seek + Send> WriteSeek for T {}

#[cfg(test)]
#[cfg(target_os = "linux")]
mod tests {
    use std::fs;

    use super::*;

    fn file(target: &Path, bytes: &[u8]) -> AtomicFile {
        let folder = Folder::open(target.parent().unwrap()).unwrap();
        let mut file = AtomicFile::create(Arc::new(folder), target, "").unwrap();
        file.write_all(bytes).unwrap();
        file
    }

    #[test]
    fn without_hard_links_the_first_one_wins_too() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let none = |_: &Folder, _: &Path, _: &Path| Err(io::Error::from(rustix::io::Errno::PERM));
        assert_eq!(file(&target, b"first").take_name(none).unwrap(), Committed::Now);
        assert_eq!(file(&target, b"second").take_name(none).unwrap(), Committed::Already);
        assert_eq!(fs::read(&target).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }

    #[test]
    fn another_error_is_not_taken_for_a_lack_of_links() {
        let folder = tempfile::tempdir().unwrap();
        let full = |_: &Folder, _: &Path, _: &Path| Err(io::Error::from(rustix::io::Errno::NOSPC));
        assert!(file(&folder.path().join("a"), b"x").take_name(full).unwrap_err().is_disk_full());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_link_that_is_done_but_answered_with_exists_has_won() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let lost_answer =
            |folder: &Folder, from: &Path, to: &Path| folder.link(from, to).and_then(|()| folder.link(from, to));
        assert_eq!(file(&target, b"first").take_name(lost_answer).unwrap(), Committed::Now);
        assert_eq!(file(&target, b"second").take_name(lost_answer).unwrap(), Committed::Already);
        assert_eq!(fs::read(&target).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }
}
