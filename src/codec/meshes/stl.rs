//! STL (3D Systems, "StereoLithography Interface Specification", 1989), binary and text, read: its triangles.
//!
//! ```text
//! binary   80 bytes of anything, u32 count; each f32 normal (3), f32 corners (9), u16: little endian
//! text     solid ..; each facet normal .. outer loop, vertex x y z three times, endloop endfacet
//! ```
//!
//! A file has no shared vertices, so corners at the very same place become one. Normals are passed over, and so is what follows the
//! triangles of a binary file. A binary file may begin with `solid`: its length tells it, or a byte 0, which no text has.

use std::collections::HashMap;
use std::io::{BufReader, Read};

use glam::DVec3;

use super::format::{MeshFormat, alone};
use super::lines::{BOM, Lines};
use crate::base::input::Input;
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::scene::survey::Polygons;

/// STL.
pub(crate) const STL: MeshFormat = MeshFormat { name: "STL", endings: &["stl"], begins, beside: alone, tell };

fn begins(start: &[u8]) -> bool {
    matches!(start.split_at_checked(5), Some((word, [b' ' | b'\t', ..])) if word.eq_ignore_ascii_case(b"solid"))
}

/// Whether a file that begins so is text: 84 bytes, or all that it has.
fn is_text(head: &[u8]) -> bool {
    let start = head.strip_prefix(BOM).unwrap_or(head).trim_ascii_start();
    start.get(..5).is_some_and(|word| word.eq_ignore_ascii_case(b"solid")) && !head.contains(&0)
}

/// The bytes before the triangles of a binary file, and those of a triangle.
const HEAD: u64 = 84;
const TRIANGLE: usize = 50;

fn tell(file: &mut Input, to: &mut dyn Polygons) -> Result<()> {
    let (path, length) = (file.path().to_owned(), file.length());
    let mut reader = BufReader::with_capacity(1 << 18, file);
    let mut head = Vec::new();
    (&mut reader).take(HEAD).read_to_end(&mut head).map_err(Error::io("read", &path))?;
    let count = head.last_chunk().map(|count| u64::from(u32::from_le_bytes(*count)));
    let whole = |count: u64| HEAD + count * TRIANGLE as u64;
    let mut welded = Welded { to, known: HashMap::new() };
    match count.filter(|_| head.len() as u64 == HEAD) {
        Some(count) if whole(count) == length || (count > 0 && whole(count) < length && !is_text(&head)) => {
            for _ in 0..count {
                let mut bytes = [0; TRIANGLE];
                reader.read_exact(&mut bytes).map_err(Error::io("read", &path))?;
                let mut numbers = bytes.as_chunks::<4>().0.iter().map(|four| f32::from_le_bytes(*four)).skip(3);
                let mut corner = || std::array::from_fn(|_| numbers.next().unwrap_or_default());
                let corners = [corner(), corner(), corner()];
                welded.add(corners).map_err(|why| Error::malformed(&path, why))?;
            }
            Ok(())
        }
        _ if is_text(&head) => {
            let start = std::io::Cursor::new(head).chain(reader);
            let mut lines = Lines::of(BufReader::new(start));
            text(&mut lines, &mut welded, &path)
        }
        Some(count) => {
            let needed = whole(count);
            Err(Error::malformed(
                &path,
                format!("it says {count} triangles, which take {needed} bytes; it has {length}"),
            ))
        }
        None => Err(Error::malformed(&path, "the file ends within its head of 84 bytes")),
    }
}

fn text(lines: &mut Lines<impl std::io::BufRead>, welded: &mut Welded<'_>, path: &std::path::Path) -> Result<()> {
    let mut corners: Vec<[f32; 3]> = Vec::new();
    while let Some((line, text)) = lines.next(path)? {
        let fault = |why: String| Error::malformed(path, format!("line {line}: {why}"));
        let mut words = text.split_ascii_whitespace();
        match words.next().map(str::to_ascii_lowercase).as_deref() {
            Some("vertex") => {
                let mut corner = [0.0; 3];
                for value in &mut corner {
                    let word = words.next().unwrap_or_default();
                    *value = word.parse().map_err(|_| fault(format!("{} is no coordinate", shown(word))))?;
                }
                corners.push(corner);
            }
            Some("endfacet") => {
                let found = corners.len();
                let three = std::mem::take(&mut corners).try_into();
                let three = three.map_err(|_| fault(format!("the facet has {found} vertices; 3 are needed")))?;
                welded.add(three).map_err(fault)?;
            }
            _ if corners.len() > 3 => return Err(fault("a facet of more than three vertices".to_owned())),
            _ => {}
        }
    }
    if corners.is_empty() { Ok(()) } else { Err(Error::malformed(path, "the file ends within a facet")) }
}

/// The receiver of a mesh, told each place once.
struct Welded<'a> {
    to: &'a mut dyn Polygons,
    known: HashMap<[u32; 3], u32>,
}

impl Welded<'_> {
    fn add(&mut self, corners: [[f32; 3]; 3]) -> Result<(), String> {
        let mut triangle = [0; 3];
        for (index, corner) in triangle.iter_mut().zip(corners) {
            // 0 and -0 are one place.
            let place = corner.map(|value| (value + 0.0).to_bits());
            *index = match self.known.get(&place) {
                Some(known) => *known,
                None => {
                    let next =
                        u32::try_from(self.known.len()).map_err(|_| "it has more than 2^32 vertices".to_owned())?;
                    self.known.insert(place, next);
                    self.to.vertex(DVec3::from(corner.map(f64::from)));
                    next
                }
            };
        }
        self.to.polygon(&triangle);
        Ok(())
    }
}
