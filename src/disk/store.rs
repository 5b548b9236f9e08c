//! What a store of write-once files must do. The same suite of tests runs on every store.

use std::fmt;
use std::io::{self, BufWriter, Write};
use std::ops::Deref;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::scratch::{Scratch, Spool};
use crate::base::key::Key;
use crate::base::{Error, Result};

/// Ends the names under which files are written; no file of a store may end so.
pub const TEMPORARY: &str = ".gonio-tmp";

/// Begins the temporary names of what is not kept.
pub const SCRATCH: &str = "scratch";

/// The longest name of a file in a store, in bytes.
const LONGEST_NAME: usize = 200;

/// Bytes gathered before they are hashed and written.
const BUFFER: usize = 1 << 17;

/// Write-once files under names such as `segments/7.seg`. Names are relative, with `/` between folders, which come and
/// go with their files. One process writes, any number of its threads.
pub trait Store: fmt::Debug + Send + Sync {
    /// Begins a file; folders are made as needed. Refuses a name that leaves the store.
    fn begin(&self, name: &str) -> Result<Box<dyn Sink>>;

    /// Begins bytes that are not kept.
    fn spool(&self) -> Result<Box<dyn Spool>>;

    /// The bytes of a committed file. They stay readable after the file is removed or replaced.
    fn open(&self, name: &str) -> Result<Content>;

    /// The size in bytes of a committed file, `None` if there is no such file.
    fn size(&self, name: &str) -> Result<Option<u64>>;

    /// The names of all committed files in a folder and below, sorted; `""` is the whole store.
    fn list(&self, folder: &str) -> Result<Vec<String>>;

    /// Gives a committed file another name, in place of the file that has it.
    fn rename(&self, from: &str, to: &str) -> Result<()>;

    /// Removes a committed file.
    fn remove(&self, name: &str) -> Result<()>;

    /// Removes what broken runs left under temporary names, and names it.
    fn sweep(&self) -> Result<Vec<String>>;

    /// The bytes that may still be written into the store; `None` where nobody says.
    fn free(&self) -> Option<u64>;

    /// What messages call a file.
    fn path(&self, name: &str) -> PathBuf;

    /// Begins bytes that are worked on and not kept, buffered.
    fn scratch(&self) -> Result<Scratch> {
        Ok(Scratch::new(self.spool()?, self.path(SCRATCH)))
    }

    /// Begins a file, buffered and hashed.
    fn create(&self, name: &str) -> Result<Draft> {
        let counted = Counted { sink: self.begin(name)?, hasher: blake3::Hasher::new(), bytes: 0 };
        Ok(Draft { out: BufWriter::with_capacity(BUFFER, counted), name: name.to_owned(), path: self.path(name) })
    }
}

/// Where a store puts the bytes of one file that is being written. Dropped uncommitted, it leaves nothing.
pub trait Sink: Write + Send {
    /// Makes the file durable under its name. Where the name is taken, `replace` says whether that file gives way or
    /// this one is refused.
    fn commit(self: Box<Self>, replace: bool) -> Result<()>;
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
    /// What messages call the file.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Makes the file durable. Refused where the name is taken.
    pub fn commit(self) -> Result<FileEntry> {
        self.conclude(false)
    }

    /// Makes the file durable, in place of the one that has its name.
    pub fn replace(self) -> Result<FileEntry> {
        self.conclude(true)
    }

    fn conclude(self, replace: bool) -> Result<FileEntry> {
        let counted = self.out.into_inner().map_err(|e| Error::io("write", &self.path)(e.into_error()))?;
        counted.sink.commit(replace)?;
        let checksum = Key(*counted.hasher.finalize().as_bytes()).to_string();
        Ok(FileEntry { name: self.name, bytes: counted.bytes, checksum })
    }
}

/// A committed file: what the manifest says of it.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FileEntry {
    /// Its name in the store.
    pub name: String,
    /// Its size.
    pub bytes: u64,
    /// BLAKE3 of its bytes, in hex.
    pub checksum: String,
}

impl FileEntry {
    /// Reads the whole file and compares it with the entry. For files that carry no checksums of their own.
    pub fn verify(&self, store: &dyn Store) -> Result<Content> {
        let content = store.open(&self.name)?;
        let found = Key::of_bytes(&content).to_string();
        if content.len() as u64 == self.bytes && found == self.checksum {
            return Ok(content);
        }
        let words = format!(
            "{} bytes with checksum {found}; the manifest names {} with {}: the file has changed since it was written",
            content.len(),
            self.bytes,
            self.checksum
        );
        Err(Error::malformed(store.path(&self.name), words))
    }
}

/// The bytes of a committed file, mapped or in memory. Cloning shares them.
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

/// Refuses a name that is none, or that could leave the store, or that is a temporary one.
pub fn check_name(name: &str) -> Result<()> {
    let part_is_bad = |part: &str| part.is_empty() || part == "." || part == "..";
    let refuse = |why: &str| Err(Error::invalid(format!("{name:?} is no name for a file of a run: {why}")));
    if name.len() > LONGEST_NAME {
        return refuse("it is longer than 200 bytes");
    }
    if name.contains(|c: char| c.is_control() || c == '\\' || c == ':') {
        return refuse("it holds a backslash, a colon or a control character");
    }
    if name.split('/').any(part_is_bad) {
        return refuse("its parts between slashes must be names, and neither empty, . nor ..");
    }
    if name.ends_with(TEMPORARY) {
        return refuse("it ends as temporary names do");
    }
    Ok(())
}
