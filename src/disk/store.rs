//! A store of write-once files. The same suite of tests runs on every store.

use std::fmt;
use std::io::{self, BufWriter, Cursor, Read, Write};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::names::{Committed, Naming, SCRATCH};
use super::scratch::{Scratch, Spool};
use crate::base::key::Key;
use crate::base::{Error, Result};

/// Bytes that are collected before they are hashed and written.
const BUFFER: usize = 1 << 17;

/// Write-once files under names such as `segments/7.seg`. Names are relative, with `/` between folders, which are made
/// with their files. Any number of threads and processes may write; of two files with one name the first wins.
pub trait Store: fmt::Debug + Send + Sync {
    /// Begins a file; folders are made as needed. Refuses a name that leaves the store.
    fn begin(&self, name: &str) -> Result<Box<dyn Sink>>;

    /// Begins bytes that are never committed.
    fn spool(&self) -> Result<Box<dyn Spool>>;

    /// The bytes of a committed file. They stay readable after the file is removed or replaced.
    fn open(&self, name: &str) -> Result<Content>;

    /// The bytes of a small committed file, copied into memory.
    fn read(&self, name: &str) -> Result<Vec<u8>> {
        Ok(self.open(name)?.to_vec())
    }

    /// Reads a committed file from its first byte to its last, without mapping or holding it.
    fn reader(&self, name: &str) -> Result<Box<dyn Read>> {
        Ok(Box::new(Cursor::new(self.open(name)?)))
    }

    /// The size in bytes of a committed file, `None` if there is no such file.
    fn size(&self, name: &str) -> Result<Option<u64>>;

    /// Whether an obstacle has this name: a folder, a link or a device, which no file can take the place of.
    fn is_obstructed(&self, name: &str) -> Result<bool> {
        let _ = name;
        Ok(false)
    }

    /// The names of the obstacles in a folder, not below it; `""` is the store's own folder.
    fn obstacles(&self, folder: &str) -> Result<Vec<String>> {
        let _ = folder;
        Ok(Vec::new())
    }

    /// The names of all committed files in a folder and below, sorted; `""` is the whole store.
    fn list(&self, folder: &str) -> Result<Vec<String>>;

    /// Gives a committed file another name, in place of the file that has it.
    fn rename(&self, from: &str, to: &str) -> Result<()>;

    /// Removes a committed file; [`Store::sync`] makes that durable.
    fn remove(&self, name: &str) -> Result<()>;

    /// Makes all names in a folder durable, and the lack of those that were removed. A folder that is not there is empty.
    fn sync(&self, folder: &str) -> Result<()>;

    /// Whether a file was made by an attempt at this run: its name carries the run's id.
    fn made(&self, name: &str) -> bool;

    /// Removes the temporary files that this run's broken attempts left, and names them. Nobody may be writing meanwhile.
    fn sweep(&self) -> Result<Vec<String>>;

    /// The bytes that may still be written into the store; `None` where the system does not say.
    fn free(&self) -> Option<u64>;

    /// The name of a file in messages.
    fn path(&self, name: &str) -> PathBuf;

    /// The name of this attempt at the run, a part of the names of a unit's files: two processes that do the same unit
    /// write different files. It begins with the run's id.
    fn attempt(&self) -> &str;

    /// Begins scratch, buffered.
    fn scratch(&self) -> Result<Scratch> {
        Ok(Scratch::new(self.spool()?, self.path(SCRATCH)))
    }

    /// Begins a file, buffered and hashed.
    fn create(&self, name: &str) -> Result<Draft> {
        let counted = Counted { sink: self.begin(name)?, hasher: blake3::Hasher::new(), bytes: 0 };
        Ok(Draft { out: BufWriter::with_capacity(BUFFER, counted), name: name.to_owned(), path: self.path(name) })
    }
}

/// The place where a store puts the bytes of one file that is being written. A sink that is dropped leaves nothing.
pub trait Sink: Write + Send {
    /// Makes the file durable under its name. `naming` says which file stays where the name is taken.
    fn commit(self: Box<Self>, naming: Naming) -> Result<Committed>;
}

/// A file that is being written.
pub struct Draft {
    out: BufWriter<Counted>,
    name: String,
    path: PathBuf,
}

struct Counted {
    sink: Box<dyn Sink>,
    hasher: blake3::Hasher,
    bytes: u64,
}

impl Write for Counted {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.sink.write(bytes)?;
        self.hasher.update(&bytes[..written]);
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.sink.flush()
    }
}

impl Write for Draft {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

impl Draft {
    /// The name of the file in messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes the file durable.
    ///
    /// # Errors
    /// The name is taken; the store fails.
    pub fn commit(self) -> Result<FileEntry> {
        let path = self.path.clone();
        match self.conclude(Naming::FirstWins)? {
            (entry, Committed::Now) => Ok(entry),
            (_, Committed::Already) => {
                let taken = io::Error::new(io::ErrorKind::AlreadyExists, "the file exists, and is written only once");
                Err(Error::io("write", path)(taken))
            }
        }
    }

    /// Makes the file durable, in place of the one that has its name.
    pub fn replace(self) -> Result<FileEntry> {
        self.conclude(Naming::Replace).map(|(entry, _)| entry)
    }

    /// Makes the file durable unless its name is taken: then these bytes are dropped, and the entry describes them.
    pub fn commit_first(self) -> Result<(FileEntry, Committed)> {
        self.conclude(Naming::FirstWins)
    }

    fn conclude(self, naming: Naming) -> Result<(FileEntry, Committed)> {
        let counted = self.out.into_inner().map_err(|e| Error::io("write", &self.path)(e.into_error()))?;
        let committed = counted.sink.commit(naming)?;
        let checksum = Key(*counted.hasher.finalize().as_bytes());
        Ok((FileEntry { name: self.name, bytes: counted.bytes, checksum }, committed))
    }
}

/// A committed file, as the record of its unit describes it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileEntry {
    /// The file's name in the store.
    pub name: String,
    /// The file's size.
    pub bytes: u64,
    /// BLAKE3 of the file's bytes.
    pub checksum: Key,
}

impl FileEntry {
    /// The bytes of the whole file, compared with the entry. For small files that carry no checksums of their own.
    pub fn verify(&self, store: &dyn Store) -> Result<Content> {
        let content = store.open(&self.name)?;
        self.compare(store, content.len() as u64, Key::of_bytes(&content))?;
        Ok(content)
    }

    /// Reads the whole file, however large, and compares it with the entry.
    pub fn check(&self, store: &dyn Store) -> Result<()> {
        let mut hasher = blake3::Hasher::new();
        hasher.update_reader(store.reader(&self.name)?).map_err(Error::io("read", store.path(&self.name)))?;
        self.compare(store, hasher.count(), Key(*hasher.finalize().as_bytes()))
    }

    fn compare(&self, store: &dyn Store, bytes: u64, found: Key) -> Result<()> {
        if bytes == self.bytes && found == self.checksum {
            return Ok(());
        }
        let words = format!(
            "{bytes} bytes with checksum {found}, but its unit names {} with {}: the file has changed since it was written",
            self.bytes, self.checksum
        );
        Err(Error::malformed(store.path(&self.name), words))
    }
}

/// The bytes of a committed file, mapped or in memory. Clones share them.
#[derive(Debug, Clone)]
pub enum Content {
    /// Mapped from a file.
    Mapped(Arc<memmap2::Mmap>),
    /// Held in memory.
    Held(Arc<[u8]>),
}

impl Deref for Content {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match self {
            Content::Mapped(map) => map,
            Content::Held(bytes) => bytes,
        }
    }
}

impl AsRef<[u8]> for Content {
    fn as_ref(&self) -> &[u8] {
        self
    }
}
