//! Scratch: any number of bytes that are written from the first to the last, changed in place, and then dropped. They lie
//! in a mapped file of the store, so the system may write pages back and drop them. The file is never committed: it has a
//! temporary name, and the file of a killed process is swept.
//!
//! All bytes are written before they are mapped, so a full disk is an error of a write.

use std::io::{self, BufWriter, Write};
use std::ops::{Deref, DerefMut};
use std::path::{Path, PathBuf};

use bytemuck::Pod;

use super::atomic::AtomicFile;
use crate::base::{Error, Result};

/// Bytes that are collected before they are written.
const BUFFER: usize = 1 << 17;

/// The place where a store puts bytes that are not kept.
pub trait Spool: Write + Send {
    /// Ends the writing: the bytes can be changed from now on.
    fn work(self: Box<Self>) -> Result<Working>;
}

/// Scratch that is being written.
pub struct Scratch {
    out: BufWriter<Box<dyn Spool>>,
    path: PathBuf,
}

impl Scratch {
    pub(super) fn new(spool: Box<dyn Spool>, path: PathBuf) -> Self {
        Scratch { out: BufWriter::with_capacity(BUFFER, spool), path }
    }

    /// The name of the scratch in messages.
    pub fn path(&self) -> &Path {
        &self.path
    }

    /// Ends the writing: the bytes can be changed from now on.
    pub fn work(self) -> Result<Working> {
        self.out.into_inner().map_err(|e| Error::io("write", &self.path)(e.into_error()))?.work()
    }
}

impl Write for Scratch {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        self.out.write(bytes)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}

/// Scratch that can be changed, mapped or in memory.
#[derive(Debug)]
pub struct Working(Place);

#[derive(Debug)]
enum Place {
    Mapped {
        map: memmap2::MmapMut,
        /// Removes the file when dropped.
        _file: AtomicFile,
    },
    Held {
        words: Vec<u64>,
        length: usize,
    },
}

impl Working {
    /// The same bytes in memory.
    pub(super) fn held(bytes: &[u8]) -> Working {
        let mut words = vec![0u64; bytes.len().div_ceil(size_of::<u64>())];
        bytemuck::cast_slice_mut(&mut words)[..bytes.len()].copy_from_slice(bytes);
        Working(Place::Held { words, length: bytes.len() })
    }

    /// All bytes as values of an alignment of at most eight bytes.
    ///
    /// # Errors
    /// The bytes are not a whole number of values.
    pub fn values<T: Pod>(&mut self) -> Result<&mut [T]> {
        let length = self.len();
        bytemuck::try_cast_slice_mut(self)
            .map_err(|why| Error::invalid(format!("{length} bytes of scratch are not a whole number of values: {why}")))
    }
}

impl Deref for Working {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        match &self.0 {
            Place::Mapped { map, .. } => map,
            Place::Held { words, length } => &bytemuck::cast_slice(words)[..*length],
        }
    }
}

impl DerefMut for Working {
    fn deref_mut(&mut self) -> &mut [u8] {
        match &mut self.0 {
            Place::Mapped { map, .. } => map,
            Place::Held { words, length } => &mut bytemuck::cast_slice_mut(words)[..*length],
        }
    }
}

impl Spool for AtomicFile {
    fn work(self: Box<Self>) -> Result<Working> {
        let map = self.map_mut()?;
        Ok(Working(Place::Mapped { map, _file: *self }))
    }
}
