//! A file in parts, read as if nothing lay between them.

use std::io::{self, BufRead, Read, Seek, SeekFrom};

use crate::base::convert::to_usize;

/// Reads parts of a file, one after the other.
pub(super) struct Parts<'a> {
    /// Every part, and the position behind its last byte.
    parts: Vec<(u64, &'a [u8])>,
    at: u64,
}

impl<'a> Parts<'a> {
    /// These parts, from the first byte on.
    pub(super) fn new(parts: impl Iterator<Item = &'a [u8]>) -> Self {
        let mut end = 0;
        let ends = parts.map(|part| {
            end += part.len() as u64;
            (end, part)
        });
        Parts { parts: ends.collect(), at: 0 }
    }

    /// The bytes from the position on that lie together.
    fn rest(&self) -> &'a [u8] {
        let next = self.parts.partition_point(|&(end, _)| end <= self.at);
        self.parts.get(next).map_or(&[], |&(end, part)| &part[part.len() - to_usize(end - self.at)..])
    }
}

impl Read for Parts<'_> {
    fn read(&mut self, buffer: &mut [u8]) -> io::Result<usize> {
        let count = self.rest().read(buffer)?;
        self.consume(count);
        Ok(count)
    }
}

impl BufRead for Parts<'_> {
    fn fill_buf(&mut self) -> io::Result<&[u8]> {
        Ok(self.rest())
    }

    fn consume(&mut self, count: usize) {
        self.at += count as u64;
    }
}

impl Seek for Parts<'_> {
    fn seek(&mut self, to: SeekFrom) -> io::Result<u64> {
        let end = self.parts.last().map_or(0, |&(end, _)| end);
        let at = match to {
            SeekFrom::Start(at) => Some(at),
            SeekFrom::End(by) => end.checked_add_signed(by),
            SeekFrom::Current(by) => self.at.checked_add_signed(by),
        };
        self.at = at.ok_or(io::ErrorKind::InvalidInput)?;
        Ok(self.at)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parts_are_read_as_one() {
        let mut parts = Parts::new([&b"ab"[..], b"", b"cde", b"f"].into_iter());
        let mut all = String::new();
        parts.read_to_string(&mut all).unwrap();
        assert_eq!(all, "abcdef");
        for at in 0..=6 {
            parts.seek(SeekFrom::Start(at as u64)).unwrap();
            let mut rest = String::new();
            parts.read_to_string(&mut rest).unwrap();
            assert_eq!(rest, all[at..]);
        }
        assert_eq!((parts.seek(SeekFrom::End(-2)).unwrap(), parts.fill_buf().unwrap()), (4, &b"e"[..]));
        assert!(parts.seek(SeekFrom::Current(-9)).is_err() && parts.seek(SeekFrom::End(9)).is_ok());
        assert!(parts.fill_buf().unwrap().is_empty());
    }
}
