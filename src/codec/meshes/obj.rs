//! Wavefront OBJ (Wavefront's Advanced Visualizer manual, appendix B1), read: its vertices and faces.
//!
//! - `v x y z`; what follows (w, a colour) is passed over. `f` with corners `v`, `v/vt`, `v//vn` or `v/vt/vn`. Indices count
//!   from 1, through the whole file; negative ones count back from the last vertex above the face.
//! - All objects and groups are one mesh. A face of n corners becomes n - 2 triangles; one of fewer than three is passed over.
//! - A backslash at the end of a line continues it, but for a comment. Every other statement (normals, materials, lines) is
//!   passed over, and so is a byte-order mark before the first. Lines end in LF, CR LF, or CR alone.

use std::io::{BufRead, BufReader, Read};
use std::path::Path;

use glam::DVec3;

use super::format::{MeshFormat, alone};
use super::lines::{BOM, line_end};
use crate::base::input::Input;
use crate::base::{Error, Result};
use crate::scene::survey::Polygons;

/// Wavefront OBJ. Any text may begin such a file: its name decides.
pub(crate) const OBJ: MeshFormat =
    MeshFormat { name: "OBJ", endings: &["obj"], begins: |_| false, beside: alone, tell };

/// The most bytes of a statement: a file of another format must not be gathered as one line.
const LONGEST: u64 = 1 << 20;

fn tell(file: &mut Input, to: &mut dyn Polygons) -> Result<()> {
    let path = &file.path().to_owned();
    let mut told = Told { to, vertices: 0, faces: 0, corners: Vec::new(), beyond: None };
    let mut lines = Lines { reader: BufReader::with_capacity(1 << 18, file), number: 0, end: b'\n' };
    lines.find_end().map_err(Error::io("read", path))?;
    let mut statement = Vec::new();
    while let Some(line) = lines.next(&mut statement).map_err(|why| why.at(path))? {
        let text = String::from_utf8_lossy(&statement);
        told.add(line, &text).map_err(|found| Error::malformed(path, format!("line {line}: {found}")))?;
    }
    told.check_beyond().map_err(|found| Error::malformed(path, found))
}

/// The vertices and faces of the statements so far.
struct Told<'a> {
    to: &'a mut dyn Polygons,
    vertices: usize,
    faces: u64,
    corners: Vec<u32>,
    /// The line, the face and the number of the last of the vertices that were named before they came.
    beyond: Option<(u64, u64, u32)>,
}

impl Told<'_> {
    /// Adds what a statement says, or says in words what is wrong with it.
    fn add(&mut self, line: u64, statement: &str) -> Result<(), String> {
        let statement = statement.split('#').next().unwrap_or_default();
        let mut words = statement.split_ascii_whitespace();
        match words.next() {
            Some("v") => self.vertex(words),
            Some("f") => self.face(line, words),
            _ => Ok(()),
        }
    }

    fn vertex<'a>(&mut self, mut words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let at = self.vertices;
        let mut xyz = [0.0; 3];
        for value in &mut xyz {
            let word = words.next().ok_or_else(|| format!("vertex {at} has fewer than three coordinates"))?;
            *value = word.parse().map_err(|_| format!("vertex {at}: {:?} is not a number", shortened(word)))?;
        }
        // One that is not finite is a fault where a face uses it.
        self.to.vertex(DVec3::from(xyz));
        self.vertices += 1;
        Ok(())
    }

    fn face<'a>(&mut self, line: u64, words: impl Iterator<Item = &'a str>) -> Result<(), String> {
        let face = self.faces;
        self.faces += 1;
        self.corners.clear();
        for word in words {
            let index = self.index(word).map_err(|why| format!("face {face}: {why}"))?;
            if index as usize >= self.vertices && self.beyond.is_none_or(|(_, _, last)| last <= index) {
                self.beyond = Some((line, face, index));
            }
            self.corners.push(index);
        }
        // A point or an edge has no surface: programs leave them behind, and pass over them.
        if self.corners.len() >= 3 {
            self.to.polygon(&self.corners);
        }
        Ok(())
    }

    /// The position of the vertex that a corner refers to.
    fn index(&self, corner: &str) -> Result<u32, String> {
        let word = corner.split('/').next().unwrap_or_default();
        let named: i64 = word.parse().map_err(|_| format!("{:?} is not a whole number", shortened(corner)))?;
        let count = i64::try_from(self.vertices).map_err(|why| why.to_string())?;
        let position = if named < 0 { count.checked_add(named) } else { named.checked_sub(1) };
        position.filter(|&p| p >= 0).and_then(|p| u32::try_from(p).ok()).ok_or_else(|| {
            format!("refers to vertex {named}, but there are {count} above it, counted from 1 or back from -1")
        })
    }

    /// Whether all vertices that were named came in the end.
    fn check_beyond(&self) -> Result<(), String> {
        match self.beyond {
            Some((line, face, last)) if last as usize >= self.vertices => {
                let (named, count) = (u64::from(last) + 1, self.vertices);
                Err(format!(
                    "line {line}: face {face}: refers to vertex {named}, but there are {count}, counted from 1"
                ))
            }
            _ => Ok(()),
        }
    }
}

fn shortened(word: &str) -> String {
    word.chars().take(40).collect()
}

/// The statements of a file.
struct Lines<'a> {
    reader: BufReader<&'a mut Input>,
    number: u64,
    /// The last byte of every line.
    end: u8,
}

/// Why there is no next statement.
enum Torn {
    Io(std::io::Error),
    TooLong(u64),
}

impl Torn {
    fn at(self, path: &Path) -> Error {
        match self {
            Torn::Io(why) => Error::io("read", path)(why),
            Torn::TooLong(line) => {
                Error::malformed(path, format!("line {line} is longer than {LONGEST} bytes: this is no OBJ file"))
            }
        }
    }
}

impl Lines<'_> {
    /// Finds how lines end, and passes over a byte-order mark.
    fn find_end(&mut self) -> std::io::Result<()> {
        let start = self.reader.fill_buf()?;
        self.end = line_end(start);
        if start.starts_with(BOM) {
            self.reader.consume(BOM.len());
        }
        Ok(())
    }

    /// Reads the next statement in place of the last; gives the number of the line that it begins in.
    fn next(&mut self, statement: &mut Vec<u8>) -> Result<Option<u64>, Torn> {
        statement.clear();
        let first = self.number + 1;
        loop {
            let left = LONGEST - statement.len() as u64;
            let read = self.reader.by_ref().take(left).read_until(self.end, statement).map_err(Torn::Io)?;
            if read == 0 {
                return Ok((!statement.is_empty()).then_some(first));
            }
            self.number += 1;
            let whole = statement.ends_with(&[self.end]);
            statement.truncate(statement.trim_ascii_end().len());
            match (whole, statement.last()) {
                (true, Some(b'\\')) if !statement.contains(&b'#') => *statement.last_mut().unwrap_or(&mut 0) = b' ',
                (false, _) if read as u64 == left => return Err(Torn::TooLong(self.number)),
                _ => return Ok(Some(first)),
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::meshes::files;
    use crate::scene::Mesh;

    fn read_text(text: &[u8]) -> Result<Mesh> {
        let dir = tempfile::tempdir().unwrap();
        let path = dir.path().join("a.obj");
        std::fs::write(&path, text).unwrap();
        files::read(&path, &|_| Ok(()))
    }

    fn refusal(text: &str) -> String {
        read_text(text.as_bytes()).unwrap_err().to_string()
    }

    const SQUARE: &str = "v 0 0 0\nv 1 0 0 1.0\nv 1 1 0 0.5 0.5 0.5\nv 0 1 0\n";

    #[test]
    fn corners_of_every_kind_are_the_same_square() {
        let square = [[0, 1, 2], [0, 2, 3]];
        for face in ["f 1 2 3 4", "f 1/5 2/6 3/7 4/8", "f 1//1 2//1 3//1 4//1", "f 1/1/1 2/2/2 3/3/3 4/4/4"] {
            assert_eq!(read_text(format!("{SQUARE}{face}").as_bytes()).unwrap().triangles[..], square, "{face}");
        }
        let split = "f -4 -3 \\\n  -2 \\\r\n -1\r\n";
        assert_eq!(read_text(format!("{SQUARE}{split}").as_bytes()).unwrap().triangles[..], square);
    }

    #[test]
    fn objects_are_one_mesh_and_other_statements_are_passed_over() {
        let text = "# made by hand\nmtllib a.mtl\no first\nv 500000 5800000 1\nv 500001 5800000 1\nv 500000 5800001 1\n\
                    vt 0 0\nvn 0 0 1\nusemtl x\ns off\nf -3 -2 -1 # in front\no second\nv 500002 5800000 1\nl 1 2\nf 2 4 3";
        let mesh = read_text(text.as_bytes()).unwrap();
        assert_eq!(mesh.triangles[..], [[0, 1, 2], [1, 3, 2]]);
        assert_eq!(mesh.origin, DVec3::new(500_001.0, 5_800_000.5, 1.0));
        let again = read_text(text.replace('\n', "\r\n").as_bytes()).unwrap();
        assert_eq!(again, mesh);
    }

    #[test]
    fn what_editors_and_programs_write_is_read() {
        let square = read_text(format!("{SQUARE}f 1 2 3 4").as_bytes()).unwrap();
        for text in [
            format!("\u{feff}{SQUARE}f 1 2 3 4"),
            format!("# made in C:\\scans\\\n{SQUARE}f 1 2 3 4"),
            format!("f 1 2 3 4\n{SQUARE}"),
            format!("{SQUARE}f 1 2 3 4").replace('\n', "\r"),
            format!("v 0 0 0 # C:\\\n{}f 1 2 3 4", &SQUARE[8..]),
            format!("{SQUARE}f 1 2\nf 1 2 3 4\nf 3\n"),
        ] {
            assert_eq!(read_text(text.as_bytes()).unwrap(), square, "{text:?}");
        }
        // A vertex that no face uses may be anything.
        let odd = read_text(format!("{SQUARE}v nan inf 0\nf 1 2 3 4").as_bytes()).unwrap();
        assert_eq!((odd.origin, &odd.triangles), (square.origin, &square.triangles));
    }

    #[test]
    fn what_is_wrong_is_told_with_its_line() {
        for (text, words) in [
            ("v 0 0\n", "line 1: vertex 0 has fewer than three coordinates"),
            ("v 0 0 zero\n", "line 1: vertex 0: \"zero\" is not a number"),
            ("v 0 0 0\nv 0 inf 0\nf 1 1 2\n", "vertex 1 is"),
            ("v 0 0 0\nv 0 NaN 0\nf 1 1 2\n", "vertex 1 is"),
            ("v 0 0 0\nf 1 1\nf 1\n", "no faces"),
            ("v 0 0 0\nf 1 2\n", "line 2: face 0: refers to vertex 2"),
            ("v 0 0 0\nf 0 1 1\n", "line 2: face 0: refers to vertex 0, but there are 1"),
            ("f 1 1 9\nf 1 1 8\nv 0 0 0\n", "line 1: face 0: refers to vertex 9, but there are 1, counted from 1"),
            ("v 0 0 0\nf 1 1 2\n", "line 2: face 0: refers to vertex 2"),
            ("v 0 0 0\n\nf 1 -2 1\n", "line 3: face 0: refers to vertex -2"),
            ("v 0 0 0\nf 1 1 1 x/1\n", "line 2: face 0: \"x/1\" is not a whole number"),
            ("v 0 0 0\nf -9223372036854775808 1 1\n", "refers to vertex -9223372036854775808"),
            ("v 0 0 0\n", "no faces"),
            ("", "no faces"),
        ] {
            let found = refusal(text);
            assert!(found.contains(words) && found.contains("a.obj"), "{text:?}: {found}");
        }
    }

    #[test]
    fn no_line_is_gathered_without_end() {
        let long = [b"f ".to_vec(), vec![b'1'; 3 << 20]].concat();
        assert!(read_text(&long).unwrap_err().to_string().contains("is longer than 1048576 bytes"));
        let continued = "f 1 \\\n".repeat(1 << 18);
        assert!(refusal(&continued).contains("is longer than 1048576 bytes"));
    }
}
