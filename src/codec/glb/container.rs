//! The container (glTF 2.0, section 4.4): a header of 12 bytes, a chunk of JSON padded by spaces, a chunk of bytes padded
//! by zeros, everything on 4 bytes.

use std::io::{self, Write};

use serde_json::Value;

/// A part of the binary chunk.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct View {
    /// Where it starts in the chunk, on 4 bytes.
    pub offset: u64,
    /// Its bytes, padding aside.
    pub length: u64,
}

impl View {
    /// Where the next one starts.
    pub fn end(&self) -> u64 {
        (self.offset + self.length).next_multiple_of(4)
    }
}

/// A file whose lengths are known and whose binary chunk is about to be written.
pub struct Container {
    json: Vec<u8>,
    binary: u64,
}

impl Container {
    /// Lays out views of these lengths, one after the other, under a document that is made of them. `None` if the file
    /// would be larger than its length field can say.
    pub fn new(lengths: impl Iterator<Item = u64>, document: impl FnOnce(&[View]) -> Value) -> Option<Self> {
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

    /// Writes all that stands before the binary chunk's bytes.
    pub fn start(&self, out: &mut (impl Write + ?Sized)) -> io::Result<()> {
        let number = |out: &mut _, value: u64| Write::write_all(out, &(value as u32).to_le_bytes());
        out.write_all(b"glTF")?;
        number(out, 2)?;
        number(out, self.length())?;
        number(out, self.json.len() as u64)?;
        out.write_all(b"JSON")?;
        out.write_all(&self.json)?;
        number(out, self.binary)?;
        out.write_all(b"BIN\0")
    }

    /// Writes one view's bytes and the padding after them.
    ///
    /// # Errors
    /// `write` writes as many bytes as the view has, or it is an error.
    pub fn view<W: Write + ?Sized>(
        &self,
        out: &mut W,
        length: u64,
        write: impl FnOnce(&mut Counted<&mut W>) -> io::Result<()>,
    ) -> io::Result<()> {
        let mut counted = Counted { out: &mut *out, bytes: 0 };
        write(&mut counted)?;
        if counted.bytes != length {
            return Err(io::Error::other(format!("{} bytes in a view of {length}", counted.bytes)));
        }
        out.write_all(&[0; 3][..(length.next_multiple_of(4) - length) as usize])
    }
}

/// Counts what goes through it.
pub struct Counted<W> {
    out: W,
    bytes: u64,
}

/// How many bytes `write` writes.
pub fn length(write: impl FnOnce(&mut Counted<io::Sink>) -> io::Result<()>) -> io::Result<u64> {
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
