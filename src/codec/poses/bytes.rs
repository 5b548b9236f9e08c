//! Binary files, little endian, read front to back. Counts are claims: nothing is held for them.

use std::io::{self, BufRead, BufReader, ErrorKind, Read};
use std::path::Path;

use crate::base::input::Input;
use crate::base::{Error, Result};

/// The most bytes of a name, its end among them.
const LONGEST_NAME: u64 = 4096;

/// A file that is read front to back, up to the length that it had when it was opened.
pub(super) struct Bytes {
    file: BufReader<Input>,
    left: u64,
    /// The system's error, if there was one: it says nothing of what the file holds.
    failed: Option<io::Error>,
}

impl Bytes {
    /// Opens a file.
    ///
    /// # Errors
    /// The system's.
    pub(super) fn open(path: &Path) -> Result<Bytes> {
        let file = Input::open(path).map_err(Error::io("open", path))?;
        let left = file.length();
        Ok(Bytes { file: BufReader::new(file), left, failed: None })
    }

    /// How many bytes are left.
    pub(super) fn left(&self) -> u64 {
        self.left
    }

    /// The next bytes.
    ///
    /// # Errors
    /// In words: the file has no more.
    pub(super) fn take<const N: usize>(&mut self) -> Result<[u8; N], String> {
        const CUT: &str = "the file ends within it; it was cut short";
        let mut bytes = [0; N];
        self.left = self.left.checked_sub(N as u64).ok_or(CUT)?;
        self.file.read_exact(&mut bytes).map_err(|why| self.keep(why, CUT))?;
        Ok(bytes)
    }

    /// The next number.
    ///
    /// # Errors
    /// Those of [`Bytes::take`].
    pub(super) fn u32(&mut self) -> Result<u32, String> {
        self.take().map(u32::from_le_bytes)
    }

    /// The next number.
    ///
    /// # Errors
    /// Those of [`Bytes::take`].
    pub(super) fn u64(&mut self) -> Result<u64, String> {
        self.take().map(u64::from_le_bytes)
    }

    /// The next number.
    ///
    /// # Errors
    /// Those of [`Bytes::take`].
    pub(super) fn f64(&mut self) -> Result<f64, String> {
        self.take().map(f64::from_le_bytes)
    }

    /// The next numbers.
    ///
    /// # Errors
    /// Those of [`Bytes::take`].
    pub(super) fn f64s<const N: usize>(&mut self) -> Result<[f64; N], String> {
        let mut all = [0.0; N];
        all.iter_mut().try_for_each(|v| self.f64().map(|read| *v = read))?;
        Ok(all)
    }

    /// The next name, which ends in a byte 0.
    ///
    /// # Errors
    /// In words: a name that is too long, cut, or no UTF-8.
    pub(super) fn name(&mut self) -> Result<String, String> {
        let mut bytes = Vec::new();
        let read = (&mut self.file).take(LONGEST_NAME.min(self.left)).read_until(0, &mut bytes);
        self.left -= read.map_err(|why| self.keep(why, "its name cannot be read"))? as u64;
        if bytes.pop() != Some(0) {
            return Err(format!("its name does not end within {LONGEST_NAME} bytes"));
        }
        String::from_utf8(bytes).map_err(|_| "its name is not UTF-8".to_owned())
    }

    /// The next name, whose length stands before it.
    ///
    /// # Errors
    /// Those of [`Bytes::name`].
    pub(super) fn counted_name(&mut self) -> Result<String, String> {
        let length = self.u64()?;
        if length > LONGEST_NAME || length > self.left {
            return Err(format!("its name is said to have {length} bytes; at most {LONGEST_NAME} are allowed"));
        }
        let mut bytes = Vec::new();
        let read = (&mut self.file).take(length).read_to_end(&mut bytes);
        self.left -= read.map_err(|why| self.keep(why, "its name cannot be read"))? as u64;
        String::from_utf8(bytes).map_err(|_| "its name is not UTF-8".to_owned())
    }

    /// Passes over bytes.
    ///
    /// # Errors
    /// In words: the file has not so many.
    pub(super) fn skip(&mut self, bytes: Option<u64>) -> Result<(), String> {
        let bytes = bytes.filter(|&n| n <= self.left).ok_or("it claims more points than the file has bytes for")?;
        self.left -= bytes;
        let seek = i64::try_from(bytes).map_err(|e| e.to_string())?;
        self.file.seek_relative(seek).map_err(|why| self.keep(why, "its points cannot be skipped"))
    }

    /// Keeps an error of the system; gives what else there is to say.
    fn keep(&mut self, why: io::Error, words: &str) -> String {
        if why.kind() != ErrorKind::UnexpectedEof {
            self.failed = Some(why);
        }
        words.to_owned()
    }

    /// What was read of the file, unless the system failed or the file was changed meanwhile.
    ///
    /// # Errors
    /// The system's; what was found wrong.
    pub(super) fn finish<T>(mut self, path: &Path, read: Result<T, String>) -> Result<T> {
        let failed = self.failed.take().map_or_else(|| self.file.get_ref().check_unchanged(), Err);
        failed.map_err(Error::io("read", path))?;
        read.map_err(|found| Error::malformed(path, found))
    }
}
