//! Object File Format (Geomview's manual, "OFF files"), text, read: its vertices and faces.
//!
//! ```text
//! OFF                          or COFF, NOFF, CNOFF, STOFF ..: what follows a vertex's three coordinates is passed over
//! vertices faces edges
//! x y z ..                     for each vertex
//! n i j k .. colours           for each face, indices counted from 0
//! ```
//!
//! What follows `#` is a comment. A face of n corners becomes n - 2 triangles; one of fewer than three is passed over.

use std::io::{BufRead, BufReader};
use std::path::Path;

use glam::DVec3;

use super::format::{MeshFormat, alone};
use super::lines::Lines;
use crate::base::input::Input;
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::scene::survey::Polygons;

/// Object File Format.
pub(crate) const OFF: MeshFormat = MeshFormat { name: "OFF", endings: &["off"], begins, beside: alone, tell };

/// The file types that begin a file.
const TYPES: [&str; 8] = ["OFF", "COFF", "NOFF", "CNOFF", "STOFF", "STCOFF", "STNOFF", "STCNOFF"];

fn begins(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    text.split_ascii_whitespace().next().is_some_and(is_type)
}

fn is_type(word: &str) -> bool {
    TYPES.iter().any(|known| word.eq_ignore_ascii_case(known))
}

fn tell(file: &mut Input, to: &mut dyn Polygons) -> Result<()> {
    let path = file.path().to_owned();
    let mut words = Statements { lines: Lines::of(BufReader::with_capacity(1 << 18, file)), path: &path, line: 0 };
    let head = words.next("the head")?;
    let mut counts: Vec<String> = head.split_ascii_whitespace().map(str::to_owned).collect();
    match counts.first().map(String::as_str) {
        Some(kind) if is_type(kind) => drop(counts.remove(0)),
        other => return Err(words.fault(format!("it begins with {}; OFF is needed", shown(other.unwrap_or_default())))),
    }
    if counts.iter().any(|word| word.eq_ignore_ascii_case("binary")) {
        return Err(words.fault("it is binary OFF: save it as text, or as PLY".to_owned()));
    }
    // The counts may stand behind the type or below it.
    let counts = if counts.is_empty() { words.next("the counts")? } else { counts.join(" ") };
    let mut counts = counts.split_ascii_whitespace().map(str::parse::<u64>);
    let (Some(Ok(vertices)), Some(Ok(faces))) = (counts.next(), counts.next()) else {
        return Err(words.fault("the counts of vertices and faces are needed".to_owned()));
    };
    for at in 0..vertices {
        let text = words.next("a vertex")?;
        let mut numbers = text.split_ascii_whitespace().map(str::parse::<f64>);
        let mut next = || numbers.next().and_then(Result::ok);
        // One that is not finite is a fault where a face uses it.
        let (Some(x), Some(y), Some(z)) = (next(), next(), next()) else {
            return Err(words.fault(format!("vertex {at} is {}; three coordinates are needed", shown(text.trim()))));
        };
        to.vertex(DVec3::new(x, y, z));
    }
    for at in 0..faces {
        let text = words.next("a face")?;
        face(&text, vertices, to).map_err(|why| words.fault(format!("face {at}: {why}")))?;
    }
    Ok(())
}

/// Tells the triangles of a face.
fn face(text: &str, vertices: u64, to: &mut dyn Polygons) -> Result<(), String> {
    let mut words = text.split_ascii_whitespace();
    let corners = words.next().and_then(|word| word.parse::<u64>().ok());
    let corners =
        corners.ok_or_else(|| format!("it is {}; the number of its corners is needed", shown(text.trim())))?;
    let mut corner = || {
        let word = words.next().ok_or_else(|| format!("it has fewer than its {corners} corners"))?;
        let index =
            word.parse::<u64>().ok().filter(|index| *index < vertices).and_then(|index| u32::try_from(index).ok());
        index.ok_or_else(|| format!("it refers to vertex {}, but there are {vertices}, counted from 0", shown(word)))
    };
    // A line bounds how many corners there are.
    let corners = (0..corners).map(|_| corner()).collect::<Result<Vec<u32>, String>>()?;
    // A point or an edge has no surface: programs leave them behind, and pass over them.
    if corners.len() >= 3 {
        to.polygon(&corners);
    }
    Ok(())
}

/// The lines of a file that are no comments and not empty.
struct Statements<'a, R> {
    lines: Lines<R>,
    path: &'a Path,
    line: u64,
}

impl<R: BufRead> Statements<'_, R> {
    fn next(&mut self, what: &str) -> Result<String> {
        while let Some((line, text)) = self.lines.next(self.path)? {
            self.line = line;
            let text = text.split('#').next().unwrap_or_default().trim();
            if !text.is_empty() {
                return Ok(text.to_owned());
            }
        }
        Err(Error::malformed(self.path, format!("the file ends where {what} should be")))
    }

    fn fault(&self, why: String) -> Error {
        Error::malformed(self.path, format!("line {}: {why}", self.line))
    }
}
