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
    pub fn padded(&self, out: &mut (impl Write + ?Sized), bytes: &[u8]) -> io::Result<()> {
        out.write_all(bytes)?;
        out.write_all(&[0; 3][..bytes.len().next_multiple_of(4) - bytes.len()])
    }
}
