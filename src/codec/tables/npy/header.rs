//! The header of an array.

use std::io::{self, Read};
use std::path::Path;

use crate::base::Error;
use crate::base::shown::{short, shown};

/// The first bytes of every file.
const MAGIC: &[u8] = b"\x93NUMPY";

/// The most bytes of a header that is read; numpy writes 128 for an ordinary array.
const HEADER_MAX: u64 = 1 << 16;

/// All bytes before the values of an array; `descr` is numpy's name of the type of a value.
///
/// # Errors
/// More dimensions than the header has room for.
pub(crate) fn heading(descr: &str, shape: &[usize]) -> io::Result<Vec<u8>> {
    let mut text = format!("{{'descr': '{descr}', 'fortran_order': False, 'shape': (");
    shape.iter().for_each(|n| text.push_str(&format!("{n}, ")));
    text.push_str("), }");
    let before = MAGIC.len() + 4;
    let padded = (before + text.len() + 1).next_multiple_of(64) - before;
    let header = format!("{text:<width$}\n", width = padded - 1);
    let length = u16::try_from(header.len())
        .map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, format!("{} dimensions are too many", shape.len())))?;
    Ok([MAGIC, &[1, 0], &length.to_le_bytes(), header.as_bytes()].concat())
}

/// Why an array could not be read.
#[derive(Debug)]
pub(super) enum Fault {
    /// The file could not be read.
    Io(io::Error),
    /// In words: the file holds no such array.
    Found(String),
}

impl Fault {
    /// The error that names the file.
    pub(super) fn of(self, path: &Path) -> Error {
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

/// The contents of a header.
#[derive(Debug)]
pub(super) struct Header {
    /// The shape of the array.
    pub shape: Vec<usize>,
    /// Whether the values are f64.
    pub wide: bool,
    /// The position of the first value in the file.
    pub start: u64,
}

/// Reads a header and checks it against the length of the file.
///
/// # Errors
/// No header of an array that fills the file to its last byte.
pub(super) fn read(file: &mut impl Read, length: u64) -> Result<Header, Fault> {
    let found = |words: String| Err(Fault::Found(words));
    let mut fixed = [0; 8];
    if length < 12 || file.read_exact(&mut fixed).is_err() || &fixed[..6] != MAGIC {
        return found("not an .npy file: it does not begin with \\x93NUMPY".into());
    }
    let mut size = [0; 4];
    let width = match fixed[6] {
        1 => 2,
        2 | 3 => 4,
        version => return found(format!("it has .npy version {version}; versions 1, 2 and 3 can be read")),
    };
    file.read_exact(&mut size[..width])?;
    let (size, before) = (u64::from(u32::from_le_bytes(size)), 8 + width as u64);
    if size > HEADER_MAX || before + size > length {
        return found(format!("it claims a header of {size} bytes in a file of {length}"));
    }
    let mut header = Vec::new();
    file.by_ref().take(size).read_to_end(&mut header)?;
    let header = String::from_utf8_lossy(&header);
    let (shape, wide) = match parse(&header) {
        Ok(parsed) => parsed,
        Err(words) => return found(format!("{words} in the header {}", shown(header.trim_end()))),
    };
    let start = before + size;
    let (width, bytes) = (if wide { 8 } else { 4 }, length - start);
    if values(&shape).and_then(|n| n.checked_mul(width)) != Some(bytes) {
        let shape = short(&format!("{shape:?}"));
        return found(format!("its shape is {shape} of {width}-byte values, but {bytes} bytes of values follow"));
    }
    Ok(Header { shape, wide, start })
}

/// The shape that a header gives, and whether the values are f64.
fn parse(header: &str) -> Result<(Vec<usize>, bool), String> {
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

/// The number of values of an array of this shape; `None` if it does not fit into 64 bits.
pub(super) fn values(shape: &[usize]) -> Option<u64> {
    shape.iter().try_fold(1u64, |n, &side| n.checked_mul(side as u64))
}
