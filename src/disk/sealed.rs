//! Sealed files: any bytes, and a footer that tells a whole file from any other. Integers are little endian.
//!
//! ```text
//! body      any number of bytes
//! length    u64      bytes of the body
//! version   u32      of the body's layout
//! crc32     u32      of the body
//! magic     8 bytes  the kind of file
//! ```
//!
//! The magic comes last: a file that was cut short lacks it. Every byte of the file is checked: the body by its crc32, the
//! length by the file's size, version and magic against the reader's.

use std::io::{self, Write};
use std::ops::Deref;

use super::store::{Content, Draft, FileEntry, Store};
use crate::base::{Error, Result};

/// Bytes of the footer.
const FOOTER: usize = 24;

/// A kind of sealed file, and the version of its layout that this program reads and writes.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Seal {
    /// The file's last eight bytes.
    pub magic: [u8; 8],
    /// The version of the layout.
    pub version: u32,
    /// The kind of file in messages: "scene cache".
    pub kind: &'static str,
}

/// A sealed file that is being written.
pub(crate) struct SealedWriter {
    draft: Draft,
    seal: Seal,
    crc: crc32fast::Hasher,
    length: u64,
}

/// A sealed file whose seal is whole; it derefs to the body.
#[derive(Debug, Clone)]
pub(crate) struct Sealed {
    content: Content,
    length: usize,
}

impl Seal {
    /// Begins a file of this kind.
    pub(crate) fn create(&self, store: &dyn Store, name: &str) -> Result<SealedWriter> {
        Ok(SealedWriter { draft: store.create(name)?, seal: *self, crc: crc32fast::Hasher::new(), length: 0 })
    }

    /// Opens a file of this kind, and reads it once from end to end.
    ///
    /// # Errors
    /// `Error::Malformed` where the file is cut short, of another kind or version, or has changed.
    pub(crate) fn open(&self, store: &dyn Store, name: &str) -> Result<Sealed> {
        let content = store.open(name)?;
        match self.length(&content) {
            Ok(length) => Ok(Sealed { content, length }),
            Err(found) => Err(Error::malformed(store.path(name), found)),
        }
    }

    /// The body's length, once all bytes have been checked.
    fn length(&self, bytes: &[u8]) -> Result<usize, String> {
        let kind = self.kind;
        let (body, footer) = bytes.split_last_chunk::<FOOTER>().ok_or_else(|| {
            format!("{} bytes are too few for a {kind}, whose footer has {FOOTER}: it was cut short", bytes.len())
        })?;
        let word = |at: usize| u32::from_le_bytes([footer[at], footer[at + 1], footer[at + 2], footer[at + 3]]);
        if footer[16..] != self.magic {
            let (found, wanted) = (footer[16..].escape_ascii(), self.magic.escape_ascii());
            return Err(format!(
                "ends in \"{found}\", but a {kind} ends in \"{wanted}\": it was cut short, or is another file"
            ));
        }
        if word(8) != self.version {
            let (found, wanted) = (word(8), self.version);
            return Err(format!(
                "{kind} of version {found}; this gonio reads version {wanted}: remove the file, and the next run makes it again"
            ));
        }
        let length = u64::from(word(0)) | u64::from(word(4)) << 32;
        if length != body.len() as u64 {
            return Err(format!("the footer says {length} bytes, but {} come before it", body.len()));
        }
        if word(12) != crc32fast::hash(body) {
            return Err(format!("the {kind} fails its checksum: it has changed since it was written"));
        }
        Ok(body.len())
    }
}

impl Write for SealedWriter {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.draft.write(bytes)?;
        self.crc.update(&bytes[..written]);
        self.length += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.draft.flush()
    }
}

impl SealedWriter {
    /// Writes the footer and makes the file durable.
    ///
    /// # Errors
    /// The name is taken; the store fails.
    pub(crate) fn seal(mut self) -> Result<FileEntry> {
        let mut footer = [0; FOOTER];
        footer[..8].copy_from_slice(&self.length.to_le_bytes());
        footer[8..12].copy_from_slice(&self.seal.version.to_le_bytes());
        footer[12..16].copy_from_slice(&self.crc.finalize().to_le_bytes());
        footer[16..].copy_from_slice(&self.seal.magic);
        self.draft.write_all(&footer).map_err(Error::io("write", self.draft.path()))?;
        self.draft.commit()
    }
}

impl Deref for Sealed {
    type Target = [u8];

    fn deref(&self) -> &[u8] {
        &self.content[..self.length]
    }
}

impl AsRef<[u8]> for Sealed {
    fn as_ref(&self) -> &[u8] {
        self
    }
}
