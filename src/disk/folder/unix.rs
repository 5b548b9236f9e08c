//! Folders by descriptors (POSIX.1-2008: `openat` and its kin).

use std::fs::File;
use std::io;
use std::os::unix::ffi::OsStrExt;
use std::path::Path;

use rustix::fs::{AtFlags, FileType, Mode, OFlags, Stat};
use rustix::io::Errno;

use super::kind::{Kind, regular, strange};
#[cfg(test)]
use crate::disk::journal::{self, Noted, Step};

/// A folder that is held open.
#[derive(Debug)]
pub(in crate::disk) struct Folder(File);

/// The permissions of new files and of new folders, before the user's mask.
const FILE: Mode = Mode::from_raw_mode(0o666);
const FOLDER: Mode = Mode::from_raw_mode(0o777);

impl Folder {
    /// Opens a folder by its path. Links in the path are followed: its owner set them.
    pub(in crate::disk) fn open(path: &Path) -> io::Result<Folder> {
        let path = if path == Path::new("") { Path::new(".") } else { path };
        Ok(Folder(rustix::fs::open(path, OFlags::DIRECTORY | OFlags::CLOEXEC, Mode::empty())?.into()))
    }

    /// Opens a folder in this one.
    pub(in crate::disk) fn folder(&self, name: &str) -> io::Result<Folder> {
        let flags = OFlags::DIRECTORY | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        match rustix::fs::openat(&self.0, name, flags, Mode::empty()) {
            Ok(found) => Ok(Folder(found.into())),
            // What the system says of a link here differs.
            Err(Errno::NOTDIR | Errno::LOOP) => Err(io::Error::new(
                io::ErrorKind::NotADirectory,
                "it is no folder: gonio follows no link here, so a link to a folder must be replaced by the folder",
            )),
            Err(why) => Err(why.into()),
        }
    }

    /// Makes a folder in this one.
    pub(in crate::disk) fn make_folder(&self, name: &str) -> io::Result<()> {
        #[cfg(test)]
        let _noted = journal::note(&self.0, |at| Step::MakeFolder(at.join(name)))?;
        Ok(rustix::fs::mkdirat(&self.0, name, FOLDER)?)
    }

    /// Opens a file to be read.
    pub(in crate::disk) fn open_file(&self, name: &str) -> io::Result<File> {
        // Without `NONBLOCK`, to open a pipe might never end.
        self.file(name, OFlags::RDONLY | OFlags::NONBLOCK)
    }

    /// Opens a file to be read and written; it is made if there is none.
    pub(in crate::disk) fn open_or_create(&self, name: &str) -> io::Result<File> {
        #[cfg(test)]
        let _noted = journal::note(&self.0, |at| Step::Create(at.join(name)))?;
        self.file(name, OFlags::RDWR | OFlags::CREATE | OFlags::NONBLOCK)
    }

    /// Makes a file, to be read and written. The error's kind is `AlreadyExists` if anything has the name.
    pub(in crate::disk) fn create_new(&self, name: &Path) -> io::Result<File> {
        #[cfg(test)]
        let _noted = journal::note(&self.0, |at| Step::Create(at.join(name)))?;
        let flags = OFlags::RDWR | OFlags::CREATE | OFlags::EXCL | OFlags::NOFOLLOW | OFlags::CLOEXEC;
        Ok(rustix::fs::openat(&self.0, name, flags, FILE)?.into())
    }

    fn file(&self, name: &str, flags: OFlags) -> io::Result<File> {
        match rustix::fs::openat(&self.0, name, flags | OFlags::NOFOLLOW | OFlags::CLOEXEC, FILE) {
            Ok(found) => regular(found.into()),
            Err(Errno::LOOP | Errno::NXIO) => Err(strange()),
            Err(why) => Err(why.into()),
        }
    }

    /// What a name stands for; `None` if there is nothing.
    pub(in crate::disk) fn kind(&self, name: &Path) -> io::Result<Option<Kind>> {
        Ok(self.stat(name)?.map(|found| kind(FileType::from_raw_mode(found.st_mode))))
    }

    /// The size in bytes of a file; `None` if no file has the name.
    pub(in crate::disk) fn size(&self, name: &Path) -> io::Result<Option<u64>> {
        let file = self.stat(name)?.filter(|found| FileType::from_raw_mode(found.st_mode) == FileType::RegularFile);
        Ok(file.map(|found| found.st_size.cast_unsigned()))
    }

    /// Whether a name stands for this open file.
    pub(in crate::disk) fn is_named(&self, file: &File, name: &Path) -> bool {
        let (own, there) = (rustix::fs::fstat(file), self.stat(name));
        matches!((own, there), (Ok(own), Ok(Some(there))) if (own.st_dev, own.st_ino) == (there.st_dev, there.st_ino))
    }

    fn stat(&self, name: &Path) -> io::Result<Option<Stat>> {
        match rustix::fs::statat(&self.0, name, AtFlags::SYMLINK_NOFOLLOW) {
            Ok(found) => Ok(Some(found)),
            Err(Errno::NOENT | Errno::NOTDIR) => Ok(None),
            Err(why) => Err(why.into()),
        }
    }

    /// The names in the folder, and what each stands for. Names that are not UTF-8 come as the system shows them.
    pub(in crate::disk) fn entries(&self) -> io::Result<Vec<(String, Option<Kind>)>> {
        let mut found = Vec::new();
        for entry in rustix::fs::Dir::read_from(&self.0)? {
            let entry = entry?;
            let name = std::ffi::OsStr::from_bytes(entry.file_name().to_bytes());
            if name != "." && name != ".." {
                let kind = match (name.to_str(), entry.file_type()) {
                    // gonio gives no file a name that is not UTF-8.
                    (None, _) => Some(Kind::Other),
                    (Some(_), FileType::Unknown) => self.kind(Path::new(name))?,
                    (Some(_), known) => Some(kind(known)),
                };
                found.push((name.to_string_lossy().into_owned(), kind));
            }
        }
        Ok(found)
    }

    /// Gives a file or whatever has the name another name, in another folder, in place of the file that has it.
    pub(in crate::disk) fn rename(&self, from: &Path, to: &Folder, name: &Path) -> io::Result<()> {
        #[cfg(test)]
        let _noted = journal::note_between(&self.0, &to.0, |at, to| Step::Rename(at.join(from), to.join(name)))?;
        Ok(rustix::fs::renameat(&self.0, from, &to.0, name)?)
    }

    /// Gives a file a second name in this folder. The error's kind is `AlreadyExists` if anything has that name.
    pub(in crate::disk) fn link(&self, from: &Path, to: &Path) -> io::Result<()> {
        #[cfg(test)]
        let _noted = journal::note(&self.0, |at| Step::Link(at.join(from), at.join(to)))?;
        Ok(rustix::fs::linkat(&self.0, from, &self.0, to, AtFlags::empty())?)
    }

    /// Renames a file unless the name is taken; then the error's kind is `AlreadyExists`.
    pub(in crate::disk) fn rename_new(&self, from: &Path, to: &Path) -> io::Result<()> {
        #[cfg(target_os = "linux")]
        {
            #[cfg(test)]
            let _noted = journal::note(&self.0, |at| Step::Rename(at.join(from), at.join(to)))?;
            let flags = rustix::fs::RenameFlags::NOREPLACE;
            Ok(rustix::fs::renameat_with(&self.0, from, &self.0, to, flags)?)
        }
        #[cfg(not(target_os = "linux"))]
        {
            let (_, _) = (from, to);
            Err(io::Error::new(io::ErrorKind::Unsupported, "this filesystem has no hard links: use another one"))
        }
    }

    /// Removes a file, or a link itself.
    pub(in crate::disk) fn remove(&self, name: &Path) -> io::Result<()> {
        #[cfg(test)]
        let _noted = journal::note(&self.0, |at| Step::Remove(at.join(name)))?;
        Ok(rustix::fs::unlinkat(&self.0, name, AtFlags::empty())?)
    }

    /// Makes the names in the folder durable.
    pub(in crate::disk) fn sync(&self) -> io::Result<()> {
        // What is noted need not be done: no test cuts the machine's power.
        #[cfg(test)]
        if journal::note(&self.0, |at| Step::SyncFolder(at.to_owned()))?.is_some() {
            return Ok(());
        }
        self.0.sync_all()
    }

    /// Notes a step on a file of this folder.
    #[cfg(test)]
    pub(in crate::disk) fn note(&self, step: impl FnOnce(&Path) -> Step) -> io::Result<Option<Noted>> {
        journal::note(&self.0, step)
    }
}

fn kind(found: FileType) -> Kind {
    match found {
        FileType::RegularFile => Kind::File,
        FileType::Directory => Kind::Folder,
        _ => Kind::Other,
    }
}

/// Whether this is how a filesystem says that it has no hard links.
pub(in crate::disk) fn has_no_links(why: &io::Error) -> bool {
    let said = [Errno::PERM, Errno::NOSYS, Errno::OPNOTSUPP, Errno::NOTSUP, Errno::MLINK];
    said.iter().any(|errno| why.raw_os_error() == Some(errno.raw_os_error()))
}
