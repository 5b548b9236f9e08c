//! Elements as text: values between white space, wherever lines end.

use std::io::BufRead;
use std::path::Path;

use glam::DVec3;

use super::faces::{self, MOST, too_many};
use super::header::{Element, Header, Kind};
use crate::base::{Error, Result};
use crate::scene::survey::Polygons;

/// The most bytes of a value: a longer one is no number, and must not be gathered.
const LONGEST: usize = 512;

/// Tells every vertex and face.
pub(super) fn read(header: &Header, reader: impl BufRead, path: &Path, to: &mut dyn Polygons) -> Result<()> {
    let mut words = Words { reader, word: Vec::new(), path };
    let vertices = header.vertex().count;
    let (mut corners, mut named) = (Vec::new(), Vec::new());
    for element in &header.elements {
        let (xyz, indices) = match element.name.as_str() {
            "vertex" => (element.xyz(), None),
            "face" => (None, element.indices()),
            _ => (None, None),
        };
        // A row without properties takes no text, however many rows the header claims.
        let rows = if element.properties.is_empty() { 0 } else { element.count };
        for row in 0..rows {
            let mut vertex = DVec3::NAN;
            for (at, property) in element.properties.iter().enumerate() {
                let axis = xyz.and_then(|xyz| xyz.iter().position(|&p| p == at));
                match (property.kind, axis) {
                    (Kind::Scalar(_), Some(axis)) => vertex[axis] = words.real(element, row)?,
                    (Kind::Scalar(_), None) => words.next(element, row)?,
                    (Kind::List { .. }, _) => {
                        let items = words.integer(element, row)?;
                        if indices == Some(at) && items > i128::from(MOST) {
                            return Err(Error::malformed(path, too_many(row, items)));
                        }
                        corners.clear();
                        for _ in 0..items {
                            if indices == Some(at) {
                                corners.push(words.integer(element, row)?);
                            } else {
                                words.next(element, row)?;
                            }
                        }
                        if indices == Some(at) {
                            faces::tell(vertices, row, &corners, &mut named, to)
                                .map_err(|found| Error::malformed(path, found))?;
                        }
                    }
                }
            }
            if xyz.is_some() {
                to.vertex(vertex);
            }
        }
    }
    Ok(())
}

/// The values of a file.
struct Words<'a, R> {
    reader: R,
    word: Vec<u8>,
    path: &'a Path,
}

impl<R: BufRead> Words<'_, R> {
    /// Moves to the next value. Errors name the row and the element that the value belongs to.
    fn next(&mut self, element: &Element, row: u64) -> Result<()> {
        self.word.clear();
        loop {
            let buffer = self.reader.fill_buf().map_err(Error::io("read", self.path))?;
            if buffer.is_empty() {
                break;
            }
            let start = if self.word.is_empty() { skip_spaces(buffer) } else { 0 };
            let rest = &buffer[start..];
            let length = rest.iter().position(u8::is_ascii_whitespace).unwrap_or(rest.len());
            self.word.extend_from_slice(&rest[..length.min(LONGEST)]);
            let (ended, used) = (length < rest.len(), start + length);
            self.reader.consume(used);
            if ended || self.word.len() >= LONGEST {
                break;
            }
        }
        if self.word.is_empty() {
            let found = format!("the file ends in {} {row} of {}: it is truncated", element.name, element.count);
            return Err(Error::malformed(self.path, found));
        }
        Ok(())
    }

    fn real(&mut self, element: &Element, row: u64) -> Result<f64> {
        self.next(element, row)?;
        self.parsed(element, row, "a number")
    }

    fn integer(&mut self, element: &Element, row: u64) -> Result<i128> {
        self.next(element, row)?;
        self.parsed(element, row, "a whole number")
    }

    fn parsed<T: std::str::FromStr>(&self, element: &Element, row: u64, what: &str) -> Result<T> {
        let parsed = std::str::from_utf8(&self.word).ok().and_then(|word| word.parse().ok());
        parsed.ok_or_else(|| {
            let word = String::from_utf8_lossy(&self.word[..self.word.len().min(40)]);
            Error::malformed(self.path, format!("{} {row}: {word:?} is not {what}", element.name))
        })
    }
}

fn skip_spaces(buffer: &[u8]) -> usize {
    buffer.iter().position(|b| !b.is_ascii_whitespace()).unwrap_or(buffer.len())
}
