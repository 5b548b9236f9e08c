//! Writes arrays.

use std::io::{self, Write};

use half::f16;

use super::header;

/// Values that are converted at a time.
const CHUNK: usize = 1 << 14;

/// Writes an array piece by piece. The shape is fixed first; [`NpyWriter::finish`] checks that it is filled.
#[derive(Debug)]
pub(crate) struct NpyWriter<W: Write> {
    out: W,
    missing: u64,
    bytes: Vec<u8>,
    halves: bool,
}

impl<W: Write> NpyWriter<W> {
    /// Writes the header of an array of f32 with this shape.
    pub(crate) fn new(out: W, shape: &[usize]) -> io::Result<Self> {
        NpyWriter::begin(out, shape, false)
    }

    /// Writes the header of an array of f16. Values are rounded to f16; those beyond its range become its largest.
    pub(crate) fn halves(out: W, shape: &[usize]) -> io::Result<Self> {
        NpyWriter::begin(out, shape, true)
    }

    fn begin(mut out: W, shape: &[usize], halves: bool) -> io::Result<Self> {
        let missing = header::values(shape);
        let missing = missing.ok_or_else(|| wrong(format!("an array of shape {shape:?} is too large")))?;
        out.write_all(&header::heading(if halves { "<f2" } else { "<f4" }, shape)?)?;
        Ok(NpyWriter { out, missing, bytes: Vec::new(), halves })
    }

    /// Appends values.
    ///
    /// # Errors
    /// Those of the output; more values than the shape has.
    pub(crate) fn write(&mut self, values: &[f32]) -> io::Result<()> {
        let after = self.missing.checked_sub(values.len() as u64);
        self.missing = after
            .ok_or_else(|| wrong(format!("{} values are written where {} are missing", values.len(), self.missing)))?;
        for chunk in values.chunks(CHUNK) {
            self.bytes.clear();
            if self.halves {
                let largest = f16::MAX.to_f32();
                self.bytes.extend(chunk.iter().flat_map(|v| f16::from_f32(v.clamp(-largest, largest)).to_le_bytes()));
            } else {
                self.bytes.extend(chunk.iter().flat_map(|v| v.to_le_bytes()));
            }
            self.out.write_all(&self.bytes)?;
        }
        Ok(())
    }

    /// Flushes the output and gives it back.
    ///
    /// # Errors
    /// Those of the output; fewer values than the shape has.
    pub(crate) fn finish(mut self) -> io::Result<W> {
        if self.missing > 0 {
            return Err(wrong(format!("{} values are missing", self.missing)));
        }
        self.out.flush()?;
        Ok(self.out)
    }
}

/// Writes a whole array.
#[cfg(test)]
pub(crate) fn write_f32<W: Write>(out: W, shape: &[usize], values: &[f32]) -> io::Result<W> {
    let mut writer = NpyWriter::new(out, shape)?;
    writer.write(values)?;
    writer.finish()
}

fn wrong(words: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, words)
}
