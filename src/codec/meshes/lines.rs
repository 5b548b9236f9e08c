//! The lines of a text that may be anything: none is gathered without end.

use std::io::{BufRead, Read};
use std::path::Path;

use crate::base::{Error, Result};

/// The most bytes of a line.
const LONGEST: u64 = 1 << 20;

/// The byte-order mark of UTF-8, as editors write it.
pub(super) const BOM: &[u8] = b"\xef\xbb\xbf";

/// The last byte of every line of a text that starts so: LF, unless lines end in CR alone.
pub(in crate::codec) fn line_end(start: &[u8]) -> u8 {
    let first = start.iter().position(|byte| matches!(byte, b'\n' | b'\r')).map(|at| &start[at..]);
    if matches!(first, Some([b'\r', next, ..]) if *next != b'\n') { b'\r' } else { b'\n' }
}

/// The lines of a file, which end in LF, CR LF, or CR alone. A byte-order mark before the first is passed over.
pub(super) struct Lines<R> {
    reader: R,
    number: u64,
    /// The last byte of every line; not known before the first.
    end: Option<u8>,
}

impl<R: BufRead> Lines<R> {
    /// The lines that a reader has from here on.
    pub(super) fn of(reader: R) -> Self {
        Lines { reader, number: 0, end: None }
    }

    /// The next line and its number, counted from 1; `None` at the end.
    ///
    /// # Errors
    /// The system's; a line of more than a MiB.
    pub(super) fn next(&mut self, path: &Path) -> Result<Option<(u64, String)>> {
        let end = match self.end {
            Some(end) => end,
            None => self.find_end().map_err(Error::io("read", path))?,
        };
        let mut bytes = Vec::new();
        let read = (&mut self.reader).take(LONGEST).read_until(end, &mut bytes);
        if read.map_err(Error::io("read", path))? == 0 {
            return Ok(None);
        }
        self.number += 1;
        if bytes.len() as u64 == LONGEST {
            return Err(Error::malformed(path, format!("line {} is longer than {LONGEST} bytes", self.number)));
        }
        Ok(Some((self.number, String::from_utf8_lossy(&bytes).into_owned())))
    }

    fn find_end(&mut self) -> std::io::Result<u8> {
        let start = self.reader.fill_buf()?;
        let end = line_end(start);
        if start.starts_with(BOM) {
            self.reader.consume(BOM.len());
        }
        self.end = Some(end);
        Ok(end)
    }
}
