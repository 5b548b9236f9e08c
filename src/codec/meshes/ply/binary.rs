//! Elements as bytes.

use std::io::Read;
use std::path::Path;

use glam::DVec3;

use super::faces::{self, MOST, too_many};
use super::header::{Element, Header, Kind, Property};
use super::scalar::{Endian, Scalar};
use crate::base::convert::to_usize;
use crate::base::{Error, Result};
use crate::scene::survey::Polygons;

/// The most rows of one length, and the most bytes of them, that are decoded at a time.
const ROWS: u64 = 1 << 14;
const CHUNK: u64 = 1 << 22;

/// Tells every vertex and face.
pub(super) fn read(
    header: &Header,
    endian: Endian,
    reader: impl Read,
    path: &Path,
    to: &mut dyn Polygons,
) -> Result<()> {
    let mut bytes = Bytes { reader, left: header.body, buffer: Vec::new(), path };
    let vertices = header.vertex().count;
    for element in &header.elements {
        let row_bytes = fixed_bytes(&element.properties);
        match (element.name.as_str(), row_bytes) {
            ("vertex", Some(stride)) => read_vertices(element, stride, endian, &mut bytes, to)?,
            ("vertex", None) => read_uneven_vertices(element, endian, &mut bytes, to)?,
            ("face", _) => read_faces(element, endian, &mut bytes, vertices, to)?,
            (_, Some(stride)) => bytes.skip(element.count.saturating_mul(stride as u64), element, 0)?,
            (_, None) => {
                for row in 0..element.count {
                    element.properties.iter().try_for_each(|p| bytes.skip_property(p, endian, element, row))?;
                }
            }
        }
    }
    Ok(())
}

/// The bytes of the properties, if none is a list.
fn fixed_bytes(properties: &[Property]) -> Option<usize> {
    let size = |p: &Property| match p.kind {
        Kind::Scalar(scalar) => Some(scalar.size()),
        Kind::List { .. } => None,
    };
    properties.iter().map(size).sum()
}

/// Tells vertices whose rows have one length: chunk by chunk, axis by axis.
fn read_vertices<R: Read>(
    element: &Element,
    stride: usize,
    endian: Endian,
    bytes: &mut Bytes<'_, R>,
    to: &mut dyn Polygons,
) -> Result<()> {
    let mut row = 0;
    let mut vertices = Vec::new();
    while row < element.count {
        let rows = (element.count - row).min(ROWS).min((CHUNK / stride as u64).max(1));
        let chunk = bytes.take(to_usize(rows) * stride, element, row)?;
        vertices.clear();
        vertices.resize(to_usize(rows), DVec3::NAN);
        for (axis, property) in element.xyz().into_iter().flatten().enumerate() {
            let (before, at) = element.properties.split_at(property);
            let (Some(offset), Kind::Scalar(scalar)) = (fixed_bytes(before), at[0].kind) else { continue };
            let mut out = vertices.iter_mut();
            scalar.reals(endian, chunk.chunks_exact(stride).map(|r| &r[offset..]), |value| {
                if let Some(vertex) = out.next() {
                    vertex[axis] = value;
                }
            });
        }
        vertices.iter().for_each(|&at| to.vertex(at));
        row += rows;
    }
    Ok(())
}

/// Tells vertices with lists among their properties: value by value.
fn read_uneven_vertices<R: Read>(
    element: &Element,
    endian: Endian,
    bytes: &mut Bytes<'_, R>,
    to: &mut dyn Polygons,
) -> Result<()> {
    let Some(xyz) = element.xyz() else { return Ok(()) };
    for row in 0..element.count {
        let mut vertex = DVec3::NAN;
        for (at, property) in element.properties.iter().enumerate() {
            match (property.kind, xyz.iter().position(|&p| p == at)) {
                (Kind::Scalar(scalar), Some(axis)) => {
                    let value = bytes.take(scalar.size(), element, row)?;
                    scalar.reals(endian, [value].into_iter(), |v| vertex[axis] = v);
                }
                _ => bytes.skip_property(property, endian, element, row)?,
            }
        }
        to.vertex(vertex);
    }
    Ok(())
}

fn read_faces<R: Read>(
    element: &Element,
    endian: Endian,
    bytes: &mut Bytes<'_, R>,
    vertices: u64,
    to: &mut dyn Polygons,
) -> Result<()> {
    let Some(indices) = element.indices() else { return Ok(()) };
    let (before, rest) = element.properties.split_at(indices);
    let (Kind::List { length, item }, after) = (rest[0].kind, &rest[1..]) else { return Ok(()) };
    let (mut corners, mut named) = (Vec::new(), Vec::new());
    for face in 0..element.count {
        before.iter().try_for_each(|p| bytes.skip_property(p, endian, element, face))?;
        let list = bytes.list_bytes(length, item, endian, element, face)?;
        let items = list / item.size();
        if items as u64 > MOST {
            return Err(Error::malformed(bytes.path, too_many(face, items as i128)));
        }
        corners.clear();
        let items = bytes.take(list, element, face)?.chunks_exact(item.size());
        item.integers(endian, items, |index| corners.push(index));
        faces::tell(vertices, face, &corners, &mut named, to).map_err(|found| Error::malformed(bytes.path, found))?;
        after.iter().try_for_each(|p| bytes.skip_property(p, endian, element, face))?;
    }
    Ok(())
}

/// The rest of the file.
struct Bytes<'a, R> {
    reader: R,
    left: u64,
    buffer: Vec<u8>,
    path: &'a Path,
}

impl<R: Read> Bytes<'_, R> {
    /// The next `n` bytes. Errors name the row and the element that they belong to. No more is allocated than the file
    /// still has.
    fn take(&mut self, n: usize, element: &Element, row: u64) -> Result<&[u8]> {
        self.spend(n as u64, element, row)?;
        self.buffer.resize(n, 0);
        self.reader.read_exact(&mut self.buffer).map_err(Error::io("read", self.path))?;
        Ok(&self.buffer)
    }

    fn skip(&mut self, n: u64, element: &Element, row: u64) -> Result<()> {
        self.spend(n, element, row)?;
        std::io::copy(&mut self.reader.by_ref().take(n), &mut std::io::sink())
            .map(drop)
            .map_err(Error::io("read", self.path))
    }

    fn skip_property(&mut self, property: &Property, endian: Endian, element: &Element, row: u64) -> Result<()> {
        let n = match property.kind {
            Kind::Scalar(scalar) => scalar.size(),
            Kind::List { length, item } => self.list_bytes(length, item, endian, element, row)?,
        };
        self.skip(n as u64, element, row)
    }

    /// Reads the length of a list, and gives the bytes of its items: no more than are left.
    fn list_bytes(
        &mut self,
        length: Scalar,
        item: Scalar,
        endian: Endian,
        element: &Element,
        row: u64,
    ) -> Result<usize> {
        let mut items = 0;
        length.integers(endian, [self.take(length.size(), element, row)?].into_iter(), |n| items = n);
        let bytes = items.saturating_mul(item.size() as i128);
        match usize::try_from(bytes) {
            Ok(bytes) if bytes as u64 <= self.left => Ok(bytes),
            _ => Err(Error::malformed(
                self.path,
                format!(
                    "{} {row} has a list of {items} items, but {} bytes of the file are left",
                    element.name, self.left
                ),
            )),
        }
    }

    fn spend(&mut self, n: u64, element: &Element, row: u64) -> Result<()> {
        self.left = self.left.checked_sub(n).ok_or_else(|| {
            let found = format!("the file ends in {} {row} of {}: it is truncated", element.name, element.count);
            Error::malformed(self.path, found)
        })?;
        Ok(())
    }
}
