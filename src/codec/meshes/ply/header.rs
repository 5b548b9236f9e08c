//! The text before the elements.

use std::io::{BufRead, Read};
use std::path::Path;

use super::scalar::{Endian, Scalar};
use crate::base::{Error, Result};
use crate::codec::meshes::lines::{BOM, line_end};

/// The most bytes of a header: a file of another format must not be read to its end in search of `end_header`.
const LONGEST: u64 = 1 << 20;

/// The encoding of the elements.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Encoding {
    Ascii,
    Binary(Endian),
}

/// The type of a property.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    Scalar(Scalar),
    List { length: Scalar, item: Scalar },
}

/// A property of an element.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Property {
    pub(super) name: String,
    pub(super) kind: Kind,
}

/// An element: a table with `count` rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Element {
    pub(super) name: String,
    pub(super) count: u64,
    pub(super) properties: Vec<Property>,
}

/// A checked header: it has vertices with coordinates and faces with indices, and the file is long enough for both.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Header {
    pub(super) encoding: Encoding,
    pub(super) elements: Vec<Element>,
    /// The bytes of the file after the header.
    pub(super) body: u64,
    vertex: usize,
}

impl Element {
    /// The fewest bytes that one row takes.
    pub(super) fn least_bytes(&self, encoding: Encoding) -> u64 {
        let of = |p: &Property| match (encoding, p.kind) {
            // A digit and what parts it from the next.
            (Encoding::Ascii, _) => 2,
            (Encoding::Binary(_), Kind::Scalar(s)) => s.size() as u64,
            (Encoding::Binary(_), Kind::List { length, .. }) => length.size() as u64,
        };
        self.properties.iter().map(of).sum()
    }

    /// The positions of the scalars `x`, `y`, `z` among the properties.
    pub(super) fn xyz(&self) -> Option<[usize; 3]> {
        let at = |name| self.properties.iter().position(|p| p.name == name && matches!(p.kind, Kind::Scalar(_)));
        Some([at("x")?, at("y")?, at("z")?])
    }

    /// The position of the list of vertex indices among the properties.
    pub(super) fn indices(&self) -> Option<usize> {
        let is = |p: &Property| {
            matches!(p.name.as_str(), "vertex_indices" | "vertex_index")
                && matches!(p.kind, Kind::List { item, .. } if item.is_integer())
        };
        self.properties.iter().position(is)
    }
}

impl Header {
    /// The element `vertex`.
    pub(super) fn vertex(&self) -> &Element {
        &self.elements[self.vertex]
    }

    /// Reads the header of a file of `length` bytes, `end_header` included.
    pub(super) fn read(reader: &mut impl BufRead, length: u64, path: &Path) -> Result<Header> {
        let mut text = Text { reader: reader.take(LONGEST.min(length)), path, number: 0, bytes: 0, end: b'\n' };
        text.find_end()?;
        if text.line()?.as_deref().map(str::trim_end) != Some("ply") {
            return Err(Error::malformed(path, "does not begin with the line \"ply\": this is no PLY file"));
        }
        let mut encoding = None;
        let mut elements: Vec<Element> = Vec::new();
        loop {
            let Some(line) = text.line()? else {
                return Err(Error::malformed(path, "the header does not end: no line \"end_header\""));
            };
            let words: Vec<&str> = line.split_ascii_whitespace().collect();
            match words.as_slice() {
                ["end_header"] => break,
                [] | ["comment" | "obj_info", ..] => {}
                ["format", name, "1.0"] => {
                    encoding = Some(match *name {
                        "ascii" => Encoding::Ascii,
                        "binary_little_endian" => Encoding::Binary(Endian::Little),
                        "binary_big_endian" => Encoding::Binary(Endian::Big),
                        _ => return Err(text.wrong(&line, "known formats are ascii and binary_(little|big)_endian")),
                    });
                }
                ["element", name, count] => {
                    let count = count.parse().map_err(|_| text.wrong(&line, "the count must be a whole number"))?;
                    elements.push(Element { name: (*name).to_owned(), count, properties: Vec::new() });
                }
                ["property", rest @ ..] => {
                    let property = Property::parse(rest).map_err(|rule| text.wrong(&line, rule))?;
                    let Some(element) = elements.last_mut() else {
                        return Err(text.wrong(&line, "a property must follow its element"));
                    };
                    element.properties.push(property);
                }
                _ => return Err(text.wrong(&line, "a format 1.0, element, property or comment is expected")),
            }
        }
        let encoding = encoding.ok_or_else(|| Error::malformed(path, "the header has no format line"))?;
        Header::check(encoding, elements, length - text.bytes).map_err(|found| Error::malformed(path, found))
    }

    fn check(encoding: Encoding, elements: Vec<Element>, body: u64) -> Result<Header, String> {
        let find = |name| {
            let mut all = elements.iter().enumerate().filter(|(_, e)| e.name == name);
            match (all.next(), all.next()) {
                (Some((at, element)), None) => Ok((at, element)),
                (None, _) => Err(format!("the header has no element {name}: this is no mesh")),
                _ => Err(format!("the header has two elements {name}")),
            }
        };
        let (vertex, element) = find("vertex")?;
        element.xyz().ok_or("element vertex must have scalar properties x, y and z")?;
        let (_, element) = find("face")?;
        element
            .indices()
            .ok_or("element face must have a list property vertex_indices (or vertex_index) of integers")?;
        if element.count == 0 {
            return Err("the mesh has no faces".into());
        }
        let mut left = body;
        for element in &elements {
            let least = element.least_bytes(encoding).saturating_mul(element.count);
            // The last value of a text may end without a space.
            if least > left.saturating_add(u64::from(encoding == Encoding::Ascii)) {
                return Err(format!(
                    "the header claims {} x {}, at least {least} bytes, but {left} are left: the file is truncated",
                    element.count, element.name
                ));
            }
            left = left.saturating_sub(least);
        }
        Ok(Header { encoding, elements, body, vertex })
    }
}

impl Property {
    fn parse(words: &[&str]) -> Result<Property, &'static str> {
        const TYPES: &str = "types are char, uchar, short, ushort, int, uint, float, double, or int8 to float64";
        let (kind, name) = match words {
            ["list", length, item, name] => {
                let length = Scalar::named(length).ok_or(TYPES)?;
                if !length.is_integer() {
                    return Err("the length of a list must be of an integer type");
                }
                (Kind::List { length, item: Scalar::named(item).ok_or(TYPES)? }, name)
            }
            [scalar, name] => (Kind::Scalar(Scalar::named(scalar).ok_or(TYPES)?), name),
            _ => return Err("a property is \"TYPE NAME\" or \"list LENGTH_TYPE ITEM_TYPE NAME\""),
        };
        Ok(Property { name: (*name).to_owned(), kind })
    }
}

/// The lines of a header.
struct Text<'a, R> {
    reader: R,
    path: &'a Path,
    number: u64,
    bytes: u64,
    /// The last byte of every line.
    end: u8,
}

impl<R: BufRead> Text<'_, R> {
    /// Finds how lines end: in `\n`, `\r\n`, or `\r` alone as the format's first description has it. Passes over a byte-order mark.
    fn find_end(&mut self) -> Result<()> {
        let start = self.reader.fill_buf().map_err(Error::io("read", self.path))?;
        self.end = line_end(start);
        if start.starts_with(BOM) {
            self.reader.consume(BOM.len());
            self.bytes += BOM.len() as u64;
        }
        Ok(())
    }

    /// The next line without its end; `None` at the end of the file or of the longest header.
    fn line(&mut self) -> Result<Option<String>> {
        let mut line = Vec::new();
        let bytes = self.reader.read_until(self.end, &mut line).map_err(Error::io("read", self.path))?;
        self.bytes += bytes as u64;
        self.number += 1;
        if line.pop() != Some(self.end) {
            return Ok(None);
        }
        Ok(Some(String::from_utf8_lossy(&line).trim_end_matches('\r').to_owned()))
    }

    fn wrong(&self, line: &str, rule: &str) -> Error {
        let line: String = line.chars().take(80).collect();
        Error::malformed(self.path, format!("header line {}, {line:?}: {rule}", self.number))
    }
}
