//! A PNG whose last chunk, IEND, is not there: recovered files and interrupted copies lack it. It holds nothing, so it is given after
//! the last byte; that nothing else is missing is found when the pixels are decoded.

use std::io::{self, BufRead, Read, Seek, SeekFrom};

/// The chunk: a length of 0, the name, and its checksum.
const END: &[u8] = b"\0\0\0\0IEND\xae\x42\x60\x82";

/// A file with the last chunk after it.
pub(super) struct Ended<R> {
    file: R,
    /// How many bytes of the chunk were given.
    given: usize,
}

impl<R> Ended<R> {
    /// The file, read from where it stands.
    pub(super) fn of(file: R) -> Self {
        Ended { file, given: 0 }
    }
}

impl<R: BufRead> BufRead for Ended<R> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        if self.given > 0 || self.file.fill_buf()?.is_empty() {
            return Ok(&END[self.given..]);
        }
        self.file.fill_buf()
    }

    fn consume(&mut self, bytes: usize) {
        if self.given > 0 || self.file.fill_buf().is_ok_and(<[u8]>::is_empty) {
            self.given = (self.given + bytes).min(END.len());
        } else {
            self.file.consume(bytes);
        }
    }
}

impl<R: BufRead> Read for Ended<R> {
    fn read(&mut self, into: &mut [u8]) -> io::Result<usize> {
        let read = self.fill_buf()?.read(into)?;
        self.consume(read);
        Ok(read)
    }
}

impl<R: Seek> Seek for Ended<R> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        self.given = 0;
        self.file.seek(to)
    }
}
