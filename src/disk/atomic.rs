//! One file, whole or not at all: temporary name, write, sync, final name, sync the folder.

use std::fs::{self, File, OpenOptions};
use std::io::{self, BufWriter, Seek, SeekFrom, Write};
use std::path::{Path, PathBuf};
use std::process;
use std::sync::atomic::{AtomicU64, Ordering};

use super::names::{Committed, Naming, TEMPORARY};
use crate::base::{Error, Result};

/// A file that is being written beside its place.
#[derive(Debug)]
pub(super) struct AtomicFile {
    file: File,
    temporary: PathBuf,
    target: PathBuf,
    /// Whether the temporary name is gone.
    renamed: bool,
}

impl AtomicFile {
    /// Begins a file in a folder that is there.
    pub(super) fn create(target: &Path) -> Result<Self> {
        static NEXT: AtomicU64 = AtomicU64::new(0);
        let name = target.file_name().ok_or_else(|| Error::invalid(format!("{} names no file", target.display())))?;
        // A device or a pipe would be replaced by a file of its name.
        if fs::metadata(target).is_ok_and(|there| !there.is_file()) {
            return Err(Error::invalid(format!("{} is not a file, so no file is put in its place", target.display())));
        }
        loop {
            let mut temporary = name.to_owned();
            let unique = NEXT.fetch_add(1, Ordering::Relaxed);
            temporary.push(format!(".{}-{unique}{TEMPORARY}", process::id()));
            let temporary = target.with_file_name(temporary);
            match OpenOptions::new().read(true).write(true).create_new(true).open(&temporary) {
                Ok(file) => return Ok(AtomicFile { file, temporary, target: target.to_owned(), renamed: false }),
                // A dead process with our id left it, or a process of another machine has our id.
                Err(why) if why.kind() == io::ErrorKind::AlreadyExists => {}
                Err(why) => return Err(Error::io("create", target)(why)),
            }
        }
    }

    /// Gives the file its name, durably, unless another file has the name and `naming` lets it stay.
    pub(super) fn commit(mut self, naming: Naming) -> Result<Committed> {
        // IMPORTANT: bytes first, then the name, then the folder that holds the name. A name that reaches the disk
        // before its bytes would leave a torn file that is trusted.
        self.file.sync_all().map_err(Error::io("sync", &self.temporary))?;
        match naming {
            Naming::Replace => {
                fs::rename(&self.temporary, &self.target)
                    .map_err(Error::io("rename a temporary file to", &self.target))?;
                self.renamed = true;
            }
            Naming::FirstWins => {
                if self.take_name(|from, to| fs::hard_link(from, to))? == Committed::Already {
                    return Ok(Committed::Already);
                }
            }
        }
        sync_folder_of(&self.target)?;
        Ok(Committed::Now)
    }

    /// Takes the name if it is free, in one step of the filesystem: two processes cannot both take it. `link` makes a
    /// hard link; where there are none, the file is renamed without replacing another.
    fn take_name(&mut self, link: impl FnOnce(&Path, &Path) -> io::Result<()>) -> Result<Committed> {
        let taken = match link(&self.temporary, &self.target) {
            Ok(()) => {
                // What cannot be removed now is swept with the other temporary files.
                self.renamed = fs::remove_file(&self.temporary).is_ok();
                Ok(())
            }
            Err(why) if has_no_links(&why) => {
                let renamed = rename_without_replace(&self.temporary, &self.target);
                self.renamed = renamed.is_ok();
                renamed
            }
            Err(why) => Err(why),
        };
        match taken {
            Ok(()) => Ok(Committed::Now),
            // NOTE: a network filesystem may do the link, lose its answer, and answer the second request with "exists".
            Err(why) if why.kind() == io::ErrorKind::AlreadyExists => {
                Ok(if self.has_its_name() { Committed::Now } else { Committed::Already })
            }
            Err(why) => Err(Error::io("name a temporary file", &self.target)(why)),
        }
    }

    /// Whether the file under the final name is this one.
    fn has_its_name(&self) -> bool {
        #[cfg(unix)]
        {
            use std::os::unix::fs::MetadataExt;
            let node = |found: fs::Metadata| (found.dev(), found.ino());
            let (own, there) = (self.file.metadata().map(node), fs::symlink_metadata(&self.target).map(node));
            matches!((own, there), (Ok(own), Ok(there)) if own == there)
        }
        #[cfg(not(unix))]
        false
    }

    /// The bytes written so far, to be changed in place.
    pub(super) fn map_mut(&self) -> Result<memmap2::MmapMut> {
        // SAFETY: this process made the file, under a name of its own that only the file's owner has. A stranger who cuts
        // the file short while it is mapped ends the process with SIGBUS, as with the files of `DirStore::open`.
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

/// Whether this is how a filesystem says that it has no hard links.
fn has_no_links(why: &io::Error) -> bool {
    #[cfg(unix)]
    {
        use rustix::io::Errno;
        let said = [Errno::PERM, Errno::NOSYS, Errno::OPNOTSUPP, Errno::NOTSUP, Errno::MLINK];
        said.iter().any(|errno| why.raw_os_error() == Some(errno.raw_os_error()))
    }
    #[cfg(not(unix))]
    {
        why.kind() == io::ErrorKind::Unsupported
    }
}

/// Renames a file unless the name is taken; then the error's kind is `AlreadyExists`.
fn rename_without_replace(from: &Path, to: &Path) -> io::Result<()> {
    #[cfg(target_os = "linux")]
    {
        use rustix::fs::{CWD, RenameFlags, renameat_with};
        Ok(renameat_with(CWD, from, CWD, to, RenameFlags::NOREPLACE)?)
    }
    #[cfg(not(target_os = "linux"))]
    {
        let (_, _) = (from, to);
        Err(io::Error::new(io::ErrorKind::Unsupported, "this filesystem has no hard links: use another one"))
    }
}

/// Makes the names in a folder durable.
pub(super) fn sync_folder(folder: &Path) -> Result<()> {
    let folder = if folder == Path::new("") { Path::new(".") } else { folder };
    File::open(folder).and_then(|f| f.sync_all()).map_err(Error::io("sync", folder))
}

/// Makes the names in a path's folder durable.
pub(super) fn sync_folder_of(path: &Path) -> Result<()> {
    sync_folder(path.parent().unwrap_or(Path::new("")))
}

/// Writes one file whole or not at all, in place of the file that is there. The folder must be there. What `write`
/// writes is buffered; an error of `write` or of the system leaves the old file as it was.
pub(crate) fn write_atomic<W>(path: impl AsRef<Path>, write: W) -> Result<()>
where
    W: FnOnce(&mut (dyn WriteSeek + '_)) -> Result<()>,
{
    let path = path.as_ref();
    let mut out = BufWriter::new(AtomicFile::create(path)?);
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
    use super::*;

    fn file(target: &Path, bytes: &[u8]) -> AtomicFile {
        let mut file = AtomicFile::create(target).unwrap();
        file.write_all(bytes).unwrap();
        file
    }

    #[test]
    fn without_hard_links_the_first_one_wins_too() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let none = |_: &Path, _: &Path| Err(io::Error::from(rustix::io::Errno::PERM));
        assert_eq!(file(&target, b"first").take_name(none).unwrap(), Committed::Now);
        assert_eq!(file(&target, b"second").take_name(none).unwrap(), Committed::Already);
        assert_eq!(fs::read(&target).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }

    #[test]
    fn another_error_is_not_taken_for_a_lack_of_links() {
        let folder = tempfile::tempdir().unwrap();
        let full = |_: &Path, _: &Path| Err(io::Error::from(rustix::io::Errno::NOSPC));
        assert!(file(&folder.path().join("a"), b"x").take_name(full).unwrap_err().is_disk_full());
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 0);
    }

    #[test]
    fn a_link_that_is_done_but_answered_with_exists_has_won() {
        let folder = tempfile::tempdir().unwrap();
        let target = folder.path().join("a");
        let lost_answer = |from: &Path, to: &Path| fs::hard_link(from, to).and_then(|()| fs::hard_link(from, to));
        assert_eq!(file(&target, b"first").take_name(lost_answer).unwrap(), Committed::Now);
        assert_eq!(file(&target, b"second").take_name(lost_answer).unwrap(), Committed::Already);
        assert_eq!(fs::read(&target).unwrap(), b"first");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1, "no temporary file is left");
    }
}
