//! NumPy's `.npy`: one array of floating point numbers, row-major.
//!
//! Layout (NEP 1): `\x93NUMPY`, version `1 0`, `u16` length of the header, the header, then the values, little endian.
//! The header is a Python literal padded with spaces so that the values start at a multiple of 64 bytes, which is what
//! lets numpy and anything else map the file as it is:
//!
//! ```text
//! {'descr': '<f4', 'fortran_order': False, 'shape': (3, 7), }
//! ```
//!
//! Written: `<f4`, or `<f2` on request, version 1. Read: `<f4` and `<f8` (rounded to f32), versions 1 to 3, row-major. The
//! shape in the header is a claim: it is checked against the file's length before anything is allocated.

use std::fs::File;
use std::io::{self, BufReader, Read, Write};
use std::path::Path;

use half::f16;

use crate::base::array::SharedBytes;
use crate::base::{Array, Error, Result};

const MAGIC: &[u8] = b"\x93NUMPY";
/// Longest header that is read; numpy writes 128 bytes for an ordinary array.
const HEADER_MAX: u64 = 1 << 16;
/// Values converted at a time.
const CHUNK: usize = 1 << 14;

/// Writes an array piece by piece. The shape is fixed first; [`NpyWriter::finish`] proves that it was filled.
#[derive(Debug)]
pub struct NpyWriter<W: Write> {
    out: W,
    missing: u64,
    bytes: Vec<u8>,
    halves: bool,
}

impl<W: Write> NpyWriter<W> {
    /// Writes the header of an array of f32 with this shape.
    pub fn new(out: W, shape: &[usize]) -> io::Result<Self> {
        NpyWriter::begin(out, shape, false)
    }

    /// The same for an array of f16, to which values are rounded; those beyond its range become its largest.
    pub fn halves(out: W, shape: &[usize]) -> io::Result<Self> {
        NpyWriter::begin(out, shape, true)
    }

    fn begin(mut out: W, shape: &[usize], halves: bool) -> io::Result<Self> {
        let kind = if halves { "<f2" } else { "<f4" };
        let mut text = format!("{{'descr': '{kind}', 'fortran_order': False, 'shape': (");
        shape.iter().for_each(|n| text.push_str(&format!("{n}, ")));
        text.push_str("), }");
        let before = MAGIC.len() + 4;
        let padded = (before + text.len() + 1).next_multiple_of(64) - before;
        let header = format!("{text:<width$}\n", width = padded - 1);
        let missing = values(shape).ok_or_else(|| wrong(format!("an array of shape {shape:?} is too large")))?;
        let length =
            u16::try_from(header.len()).map_err(|_| wrong(format!("{} dimensions are too many", shape.len())))?;
        out.write_all(MAGIC)?;
        out.write_all(&[1, 0])?;
        out.write_all(&length.to_le_bytes())?;
        out.write_all(header.as_bytes())?;
        Ok(NpyWriter { out, missing, bytes: Vec::new(), halves })
    }

    /// Appends values; an error if the shape has no room for them.
    pub fn write(&mut self, values: &[f32]) -> io::Result<()> {
        let after = self.missing.checked_sub(values.len() as u64);
        self.missing = after.ok_or_else(|| wrong(format!("{} values where {} fit", values.len(), self.missing)))?;
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

    /// Flushes and gives the output back; an error if values are missing.
    pub fn finish(mut self) -> io::Result<W> {
        if self.missing > 0 {
            return Err(wrong(format!("{} values are missing", self.missing)));
        }
        self.out.flush()?;
        Ok(self.out)
    }
}

/// Writes a whole array.
pub fn write_f32<W: Write>(out: W, shape: &[usize], values: &[f32]) -> io::Result<W> {
    let mut writer = NpyWriter::new(out, shape)?;
    writer.write(values)?;
    writer.finish()
}

/// Reads a whole array: its shape, and its values row by row.
///
/// # Errors
/// What the file holds instead of an array of `<f4` or `<f8` that fills it to the last byte.
pub fn read_f32(path: &Path) -> Result<(Vec<usize>, Vec<f32>)> {
    let file = File::open(path).map_err(Error::io("open", path))?;
    let length = file.metadata().map_err(Error::io("read", path))?.len();
    parse(BufReader::new(file), length).map_err(|fault| fault.of(path))
}

/// Reads an array of the shape `[n, columns]`: `n` rows, one after the other.
///
/// # Errors
/// As [`read_f32`], and any other shape.
pub fn read_rows<const COLUMNS: usize>(path: &Path) -> Result<Vec<[f32; COLUMNS]>> {
    rows(read_f32(path)?, path)
}

/// The same where the file's bytes are shared, as those of a mapped file: rows of f32 stay where they lie, and no more than
/// their header is looked at. `path` is what errors name.
///
/// # Errors
/// As [`read_rows`].
pub fn view<const COLUMNS: usize>(bytes: SharedBytes, path: &Path) -> Result<Array<[f32; COLUMNS]>> {
    let all = (*bytes).as_ref();
    let header = header(&mut &all[..], all.len() as u64).map_err(|fault| fault.of(path))?;
    if header.wide || cfg!(target_endian = "big") {
        let found = parse(all, all.len() as u64).map_err(|fault| fault.of(path))?;
        return Ok(rows(found, path)?.into());
    }
    check_columns::<COLUMNS>(&header.shape, path)?;
    Array::view(&bytes, header.start as usize..all.len()).map_err(|found| Error::malformed(path, found))
}

fn check_columns<const COLUMNS: usize>(shape: &[usize], path: &Path) -> Result<()> {
    if matches!(shape, [_, columns] if *columns == COLUMNS) {
        return Ok(());
    }
    Err(Error::malformed(path, format!("shape {shape:?}, where [n, {COLUMNS}] is needed")))
}

fn rows<const COLUMNS: usize>((shape, values): (Vec<usize>, Vec<f32>), path: &Path) -> Result<Vec<[f32; COLUMNS]>> {
    check_columns::<COLUMNS>(&shape, path)?;
    // In place, as a rule; a table may be a large part of the memory that there is.
    Ok(bytemuck::allocation::try_cast_vec(values).unwrap_or_else(|(_, values)| values.as_chunks().0.to_vec()))
}

/// Why an array could not be read.
#[derive(Debug)]
enum Fault {
    Io(io::Error),
    Found(String),
}

impl Fault {
    fn of(self, path: &Path) -> Error {
        match self {
            Fault::Io(source) => Error::io("read", path)(source),
            Fault::Found(found) => Error::malformed(path, found),
        }
    }
}

impl From<io::Error> for Fault {
    fn from(error: io::Error) -> Self {
        Fault::Io(error)
    }
}

/// What stands before the values.
struct Header {
    shape: Vec<usize>,
    /// Whether the values are f64.
    wide: bool,
    /// Where they start.
    start: u64,
}

/// Reads a header and holds it against the length of the file.
fn header(file: &mut impl Read, length: u64) -> Result<Header, Fault> {
    let found = |words: String| Err(Fault::Found(words));
    let mut fixed = [0; 8];
    if length < 12 || file.read_exact(&mut fixed).is_err() || &fixed[..6] != MAGIC {
        return found("no .npy file: it does not begin with \\x93NUMPY".into());
    }
    let mut size = [0; 4];
    let width = match fixed[6] {
        1 => 2,
        2 | 3 => 4,
        version => return found(format!(".npy version {version}; 1, 2 and 3 can be read")),
    };
    file.read_exact(&mut size[..width])?;
    let (size, before) = (u64::from(u32::from_le_bytes(size)), 8 + width as u64);
    if size > HEADER_MAX || before + size > length {
        return found(format!("a header of {size} bytes in a file of {length}"));
    }
    let mut header = Vec::new();
    file.by_ref().take(size).read_to_end(&mut header)?;
    let header = String::from_utf8_lossy(&header);
    let (shape, wide) = match meaning(&header) {
        Ok(meaning) => meaning,
        Err(words) => return found(format!("{words} in the header {:?}", header.trim_end())),
    };
    let start = before + size;
    let (width, bytes) = (if wide { 8 } else { 4 }, length - start);
    if values(&shape).and_then(|n| n.checked_mul(width)) != Some(bytes) {
        return found(format!("shape {shape:?} of {width}-byte values, but {bytes} bytes of them"));
    }
    Ok(Header { shape, wide, start })
}

fn parse(mut file: impl Read, length: u64) -> Result<(Vec<usize>, Vec<f32>), Fault> {
    let Header { shape, wide, start } = header(&mut file, length)?;
    let (width, bytes) = (if wide { 8 } else { 4 }, length - start);
    let mut raw = Vec::new();
    let mut out = Vec::with_capacity((bytes / width) as usize);
    loop {
        raw.clear();
        if file.by_ref().take(CHUNK as u64 * width).read_to_end(&mut raw)? == 0 {
            break;
        }
        if wide {
            out.extend(raw.as_chunks().0.iter().map(|v| f64::from_le_bytes(*v) as f32));
        } else {
            out.extend(raw.as_chunks().0.iter().map(|v| f32::from_le_bytes(*v)));
        }
    }
    if out.len() as u64 * width != bytes {
        let read = out.len() as u64 * width;
        return Err(Fault::Found(format!("{bytes} bytes of values when opened, {read} when read")));
    }
    Ok((shape, out))
}

/// Shape of a header, and whether its values are f64.
fn meaning(header: &str) -> Result<(Vec<usize>, bool), String> {
    let field = |name: &str| {
        let (_, rest) = header.split_once(&format!("'{name}'"))?;
        rest.trim_start().strip_prefix(':').map(str::trim_start)
    };
    let descr = field("descr").and_then(|v| v.strip_prefix('\'')?.split_once('\''));
    let wide = match descr {
        Some(("<f4", _)) => false,
        Some(("<f8", _)) => true,
        _ => return Err("no 'descr' of '<f4' or '<f8'".into()),
    };
    if !field("fortran_order").is_some_and(|v| v.starts_with("False")) {
        return Err("no 'fortran_order' of False (save it again with numpy.ascontiguousarray)".into());
    }
    let shape = field("shape").and_then(|v| v.strip_prefix('(')?.split_once(')'));
    let shape = shape.and_then(|(list, _)| {
        let items = list.split(',').map(str::trim).filter(|n| !n.is_empty());
        items.map(|n| n.parse().ok()).collect::<Option<Vec<usize>>>()
    });
    Ok((shape.ok_or("no 'shape' of whole numbers")?, wide))
}

/// Values that an array of this shape holds; `None` if they cannot be counted.
fn values(shape: &[usize]) -> Option<u64> {
    shape.iter().try_fold(1u64, |n, &side| n.checked_mul(side as u64))
}

fn wrong(words: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, words)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn read(bytes: &[u8]) -> Result<(Vec<usize>, Vec<f32>), Fault> {
        parse(bytes, bytes.len() as u64)
    }

    /// A file with this header, and `data` bytes of values.
    fn file(header: &str, data: usize) -> Vec<u8> {
        let mut out = b"\x93NUMPY\x01\x00".to_vec();
        out.extend((header.len() as u16).to_le_bytes());
        out.extend(header.bytes().chain(std::iter::repeat_n(0, data)));
        out
    }

    #[test]
    fn arrays_come_back_as_written() {
        let values: Vec<f32> = (0..21).map(|i| i as f32 / 7.0 - 1.0).collect();
        for shape in [vec![21], vec![3, 7], vec![3, 1, 7], vec![0, 7], vec![]] {
            let n = shape.iter().product();
            let bytes = write_f32(Vec::new(), &shape, &values[..n]).unwrap();
            assert_eq!((bytes.len() - 4 * n) % 64, 0, "{shape:?}");
            assert_eq!(read(&bytes).unwrap(), (shape, values[..n].to_vec()));
        }
    }

    #[test]
    fn what_numpy_writes_is_read() {
        let mut bytes = file("{'descr': '<f8', 'fortran_order': False, 'shape': (2,), }     \n", 0);
        bytes.extend([1.5f64, -0.25].iter().flat_map(|v| v.to_le_bytes()));
        assert_eq!(read(&bytes).unwrap(), (vec![2], vec![1.5, -0.25]));
    }

    #[test]
    fn a_view_is_the_rows_where_they_lie() {
        let values: Vec<f32> = (0..21).map(|i| i as f32 / 7.0 - 1.0).collect();
        let view = |bytes: Vec<u8>| view::<7>(std::sync::Arc::new(bytes), Path::new("a.npy"));
        let rows = view(write_f32(Vec::new(), &[3, 7], &values).unwrap()).unwrap();
        assert_eq!(rows.as_flattened(), values);
        let mut wide = file("{'descr': '<f8', 'fortran_order': False, 'shape': (1, 7), }     \n", 0);
        wide.extend([1.5f64; 7].iter().flat_map(|v| v.to_le_bytes()));
        assert_eq!(*view(wide).unwrap(), [[1.5; 7]]);
        for shape in [&[7, 3][..], &[21], &[3, 7, 1]] {
            let refusal = view(write_f32(Vec::new(), shape, &values).unwrap()).unwrap_err().to_string();
            assert!(refusal.contains("[n, 7] is needed"), "{refusal}");
        }
        let mut short = write_f32(Vec::new(), &[3, 7], &values).unwrap();
        short.pop();
        assert!(view(short).is_err());
    }

    #[test]
    fn a_writer_holds_the_caller_to_the_shape() {
        let mut writer = NpyWriter::new(Vec::new(), &[2, 2]).unwrap();
        writer.write(&[1.0, 2.0, 3.0]).unwrap();
        assert!(writer.write(&[4.0, 5.0]).is_err());
        let mut writer = NpyWriter::new(Vec::new(), &[2, 2]).unwrap();
        writer.write(&[1.0, 2.0, 3.0]).unwrap();
        assert!(writer.finish().is_err());
        assert!(NpyWriter::new(Vec::new(), &[usize::MAX, 3]).is_err());
    }

    #[test]
    fn garbage_is_refused_in_words() {
        let good = "{'descr': '<f4', 'fortran_order': False, 'shape': (2, 3), }\n";
        assert!(read(&file(good, 24)).is_ok());
        for (header, data, words) in [
            (good, 23, "23 bytes"),
            (good, 25, "25 bytes"),
            (&good.replace("2, 3", "4294967296, 4294967296"), 24, "24 bytes"),
            (&good.replace("2, 3", "-2, 3"), 24, "whole numbers"),
            (&good.replace("(2, 3)", "(2"), 24, "whole numbers"),
            (&good.replace("<f4", ">f4"), 24, "'<f4' or '<f8'"),
            (&good.replace("'<f4'", "[('x', '<f4')]"), 24, "'<f4' or '<f8'"),
            (&good.replace("False", "True"), 24, "ascontiguousarray"),
            ("", 24, "'descr'"),
        ] {
            match read(&file(header, data)) {
                Err(Fault::Found(said)) => assert!(said.contains(words), "{said}"),
                other => panic!("{header}: {other:?}"),
            }
        }
    }

    #[test]
    fn every_truncation_and_any_first_byte_is_an_error_and_no_panic() {
        let bytes = write_f32(Vec::new(), &[2, 3], &[0.5; 6]).unwrap();
        for n in 0..bytes.len() {
            assert!(read(&bytes[..n]).is_err(), "{n}");
        }
        for at in 0..10 {
            for value in [0, 1, 2, 7, 0x7f, 0xff] {
                let mut poisoned = bytes.clone();
                poisoned[at] = value;
                let kept = poisoned == bytes;
                // A minor version is not looked at.
                assert!(read(&poisoned).is_err() || kept || at == 7, "{at} {value}");
            }
        }
    }
}
