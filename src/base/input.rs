//! Input files: files of others. They are opened through one door, and what is hashed of a file is what is used of it: its
//! bytes are read once, or from one descriptor whose length and times are looked at again at the end. They are not mapped,
//! since whoever cuts a mapped file short ends the process.

use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Path, PathBuf};
use std::time::SystemTime;

#[cfg(test)]
use super::faulty_input::{self, Fault};
use super::key::Key;

/// An input file that is open, from its first byte on.
#[derive(Debug)]
pub(crate) struct Input {
    path: PathBuf,
    file: File,
    stamp: Stamp,
}

/// What tells a file that was changed from one that was not.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Stamp {
    bytes: u64,
    modified: Option<SystemTime>,
    /// The time of the last change, in seconds and nanoseconds; nobody but the system sets it.
    changed: (i64, i64),
}

impl Stamp {
    fn of(found: &Metadata) -> Stamp {
        #[cfg(unix)]
        let changed = {
            use std::os::unix::fs::MetadataExt;
            (found.ctime(), found.ctime_nsec())
        };
        #[cfg(not(unix))]
        let changed = (0, 0);
        Stamp { bytes: found.len(), modified: found.modified().ok(), changed }
    }
}

impl Input {
    /// Opens a regular file. A pipe and a device are refused: to open one, or to read it, might never end.
    ///
    /// # Errors
    /// The system's; `InvalidInput` for a pipe or a device, `IsADirectory` for a folder.
    pub(crate) fn open(path: &Path) -> io::Result<Input> {
        #[cfg(test)]
        faulty_input::step(path)?;
        regular(&fs::metadata(path)?)?;
        let mut options = OpenOptions::new();
        options.read(true);
        // What was a file a moment ago may be a pipe now.
        #[cfg(unix)]
        std::os::unix::fs::OpenOptionsExt::custom_flags(
            &mut options,
            rustix::fs::OFlags::NONBLOCK.bits().cast_signed(),
        );
        let file = options.open(path)?;
        let found = file.metadata()?;
        regular(&found)?;
        Ok(Input { path: path.to_owned(), file, stamp: Stamp::of(&found) })
    }

    /// The path under which the file was opened.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// The file's length when it was opened.
    pub(crate) fn length(&self) -> u64 {
        self.stamp.bytes
    }

    /// The key of the file's bytes. The next read begins at the first byte.
    pub(crate) fn key(&mut self) -> io::Result<Key> {
        self.rewind()?;
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(&mut *self)?;
        self.check_unchanged()?;
        self.rewind()?;
        Ok(Key(*hasher.finalize().as_bytes()))
    }

    /// All bytes of the file.
    ///
    /// # Errors
    /// The system's; the file has no longer the length that it had when it was opened.
    pub(crate) fn read_all(mut self) -> io::Result<Vec<u8>> {
        let length = usize::try_from(self.stamp.bytes).map_err(io::Error::other)?;
        // One byte more, so that the end is found without growing the vector.
        let mut bytes = Vec::new();
        bytes.try_reserve_exact(length + 1)?;
        let most = self.stamp.bytes + 1;
        (&mut self).take(most).read_to_end(&mut bytes)?;
        if bytes.len() == length { Ok(bytes) } else { Err(changed()) }
    }

    /// Refuses a file that was changed since it was opened.
    ///
    /// # Errors
    /// It was, or the system does not say.
    pub(crate) fn check_unchanged(&self) -> io::Result<()> {
        if Stamp::of(&self.file.metadata()?) == self.stamp { Ok(()) } else { Err(changed()) }
    }
}

/// An input file that was closed. What is opened again is the very file that it was.
#[derive(Debug, Clone)]
pub(crate) struct Closed {
    path: PathBuf,
    stamp: Stamp,
}

impl Input {
    /// Closes the file for now.
    pub(crate) fn close(self) -> Closed {
        Closed { path: self.path, stamp: self.stamp }
    }
}

impl Closed {
    /// The path under which the file was opened.
    pub(crate) fn path(&self) -> &Path {
        &self.path
    }

    /// Opens the file again.
    ///
    /// # Errors
    /// Those of [`Input::open`]; another file is there, or the file was changed.
    pub(crate) fn open(&self) -> io::Result<Input> {
        let file = Input::open(&self.path)?;
        if file.stamp == self.stamp { Ok(file) } else { Err(changed()) }
    }
}

impl Read for Input {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        #[cfg(test)]
        if let Some(Fault::Short) = faulty_input::step(&self.path)? {
            let few = buffer.len().min(1);
            return self.file.read(&mut buffer[..few]);
        }
        self.file.read(buffer)
    }
}

impl Seek for Input {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.file.seek(to)
    }
}

fn changed() -> io::Error {
    io::Error::other("it was changed while it was read")
}

fn regular(found: &Metadata) -> io::Result<()> {
    if found.is_file() {
        return Ok(());
    }
    let (kind, words) = if found.is_dir() {
        (io::ErrorKind::IsADirectory, "it is a folder, not a file")
    } else {
        (io::ErrorKind::InvalidInput, "it is a pipe or a device, not a file: put the file itself there")
    };
    Err(io::Error::new(kind, words))
}

#[cfg(all(test, unix))]
mod tests {
    use std::io::Write;

    use super::*;

    #[test]
    fn only_files_are_opened_and_nothing_hangs() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        fs::write(at("file"), "bytes").unwrap();
        std::os::unix::fs::symlink(at("file"), at("link")).unwrap();
        std::os::unix::fs::symlink("/dev/zero", at("zero")).unwrap();
        rustix::fs::mknodat(rustix::fs::CWD, at("pipe"), rustix::fs::FileType::Fifo, rustix::fs::Mode::RWXU, 0)
            .unwrap();
        assert!(Input::open(&at("file")).is_ok() && Input::open(&at("link")).is_ok());
        for name in ["pipe", "zero"] {
            let why = Input::open(&at(name)).unwrap_err();
            assert!(why.to_string().contains("a pipe or a device, not a file"), "{name}: {why}");
        }
        assert_eq!(Input::open(folder.path()).unwrap_err().kind(), io::ErrorKind::IsADirectory);
        assert_eq!(Input::open(&at("nothing")).unwrap_err().kind(), io::ErrorKind::NotFound);
    }

    #[test]
    fn a_file_that_changes_while_it_is_read_is_not_used() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("a.jpg");
        let appended = |bytes: &[u8]| File::options().append(true).open(&path).unwrap().write_all(bytes).unwrap();
        fs::write(&path, "bytes").unwrap();
        let mut input = Input::open(&path).unwrap();
        assert_eq!((input.key().unwrap(), input.length()), (Key::of_bytes(b"bytes"), 5));
        input.check_unchanged().unwrap();
        let late = Input::open(&path).unwrap();
        appended(b"more");
        assert!(input.check_unchanged().is_err() && input.key().is_err());
        assert!(late.read_all().unwrap_err().to_string().contains("it was changed while it was read"));
        let whole = Input::open(&path).unwrap();
        // Another file under the name is another file: the one that is open stays whole.
        fs::write(folder.path().join("b"), "other").unwrap();
        fs::rename(folder.path().join("b"), &path).unwrap();
        assert_eq!(whole.read_all().unwrap(), b"bytesmore");
        let cut = Input::open(&path).unwrap();
        File::options().write(true).open(&path).unwrap().set_len(2).unwrap();
        assert!(cut.read_all().is_err());
    }
}
