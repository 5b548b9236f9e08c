//! The container (glTF 2.0, section 4.4): a header of 12 bytes, a chunk of JSON padded by spaces, a chunk of bytes padded
//! by zeros, everything on 4 bytes.

use std::io::{self, Write};

use serde_json::Value;

use crate::base::convert::{to_u32, to_usize};

/// A range of the binary chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct View {
    /// The position of its first byte in the chunk, a multiple of 4.
    pub offset: u64,
    /// The number of its bytes, without padding.
    pub length: u64,
}

impl View {
    /// The position of the next view.
    pub(super) fn end(&self) -> u64 {
        (self.offset + self.length).next_multiple_of(4)
    }
}

/// A file whose lengths are known, before its binary chunk is written.
pub(super) struct Container {
    json: Vec<u8>,
    binary: u64,
}

impl Container {
    /// Lays out views of these lengths, one after the other, under the document that `document` makes of them. `None` if
    /// the length of the file does not fit into its length field.
    pub(super) fn new(lengths: impl Iterator<Item = u64>, document: impl FnOnce(&[View]) -> Value) -> Option<Self> {
        let mut views: Vec<View> = Vec::new();
        for length in lengths {
            views.push(View { offset: views.last().map_or(0, View::end), length });
        }
        let mut json = document(&views).to_string().into_bytes();
        json.resize(json.len().next_multiple_of(4), b' ');
        let container = Container { json, binary: views.last().map_or(0, View::end) };
        u32::try_from(container.length()).ok().map(|_| container)
    }

    fn length(&self) -> u64 {
        12 + 8 + self.json.len() as u64 + 8 + self.binary
    }

    /// Writes everything before the bytes of the binary chunk.
    pub(super) fn start(&self, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
        // The constructor has seen to it that the sum fits.
        let number = |value: u64| to_u32(to_usize(value)).to_le_bytes();
        out.write_all(b"glTF")?;
        out.write_all(&number(2))?;
        out.write_all(&number(self.length()))?;
        out.write_all(&number(self.json.len() as u64))?;
        out.write_all(b"JSON")?;
        out.write_all(&self.json)?;
        out.write_all(&number(self.binary))?;
        out.write_all(b"BIN\0")
    }

    /// Writes the bytes of a view and the padding after them.
    ///
    /// # Errors
    /// Those of `write`; another number of bytes than the view has.
    pub(super) fn view<W: Write + ?Sized>(
        &self,
        out: &mut W,
        length: u64,
        write: impl FnOnce(&mut Counted<&mut W>) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut counted = Counted { out: &mut *out, bytes: 0 };
        write(&mut counted)?;
        if counted.bytes != length {
            return Err(io::Error::other(format!("{} bytes were written to a view of {length}", counted.bytes)));
        }
        out.write_all(&[0; 3][..to_usize(length.next_multiple_of(4) - length)])
    }
}

/// Counts the bytes that are written through it.
pub(super) struct Counted<W> {
    out: W,
    bytes: u64,
}

/// The number of bytes that `write` writes.
pub(super) fn length(write: impl FnOnce(&mut Counted<io::Sink>) -> io::Result<()>) -> io::Result<u64> {
    let mut counted = Counted { out: io::sink(), bytes: 0 };
    write(&mut counted)?;
    Ok(counted.bytes)
}

impl<W: Write> Write for Counted<W> {
    fn write(&mut self, bytes: &[u8]) -> io::Result<usize> {
        let written = self.out.write(bytes)?;
        self.bytes += written as u64;
        Ok(written)
    }

    fn flush(&mut self) -> io::Result<()> {
        self.out.flush()
    }
}
