//! The table of a registration. A line at its start names the columns, in upper or lower case:
//!
//! ```text
//! #cameras 3                                                      newer versions only
//! #name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2
//! ```
//!
//! Cells are parted by commas, semicolons or tabs, and may stand in quotes.
//! With the camera's axes x right, y up, z back, the rotation to the world is Rz(-heading) Rx(pitch) Ry(roll).

use std::collections::BTreeMap;
use std::path::Path;
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};

use super::lens;
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::poses::format::Posed;
use crate::codec::poses::photographs::Photographs;
use crate::codec::poses::posed::{self, Y_UP};
use crate::codec::poses::{names, whole, words};
use crate::scene::camera::{Distortion, Projection};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// The columns that must be there.
const NEEDED: [&str; 8] = ["name", "x", "y", "alt", "heading", "pitch", "roll", "f"];

/// The most lines before the one that names the columns.
const BEFORE: usize = 8;

/// What may part the cells of a line.
const PARTS: [char; 3] = [',', ';', '\t'];

/// Whether a file that begins so is such a table.
pub(super) fn is_one(start: &str) -> bool {
    head(start).is_ok()
}

/// The line that names the columns.
struct Head {
    /// The number of lines before the first row.
    lines: usize,
    /// What parts the cells.
    part: char,
    /// The position of each column.
    columns: BTreeMap<String, usize>,
}

/// The first line that names all columns that are needed.
///
/// # Errors
/// In words: the column that the line lacks which names the most.
fn head(text: &str) -> Result<Head, String> {
    let mut most = (0, NEEDED[0]);
    for (at, line) in text.lines().enumerate().take(BEFORE) {
        for part in PARTS {
            let named = cells(line.trim_start_matches('#'), part).into_iter().map(str::to_ascii_lowercase);
            let columns: BTreeMap<String, usize> = named.zip(0..).collect();
            let Some(missing) = NEEDED.into_iter().find(|name| !columns.contains_key(*name)) else {
                return Ok(Head { lines: at + 1, part, columns });
            };
            let named = NEEDED.into_iter().filter(|name| columns.contains_key(*name)).count();
            if named > most.0 {
                most = (named, missing);
            }
        }
    }
    Err(format!("no line at its start names a column {}; {} are needed", most.1, NEEDED.join(", ")))
}

/// The cells of a line. One in quotes may hold what parts the others.
fn cells(line: &str, part: char) -> Vec<&str> {
    let mut quoted = false;
    let parts = line.split(|c: char| {
        quoted ^= c == '"';
        c == part && !quoted
    });
    parts.map(|cell| cell.trim().trim_matches('"').trim()).collect()
}

/// Reads a table.
///
/// # Errors
/// A file that cannot be read, a line that is not as the first says, an image whose size cannot be read.
pub(super) fn read(file: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let text = whole::text(file)?;
    let head = head(&text).map_err(|why| Error::malformed(file, why))?;
    let lines = text.lines().enumerate().skip(head.lines).filter(|(_, line)| !line.trim().is_empty());
    let rows: Vec<Row<'_>> =
        lines.map(|(at, line)| Row { cells: cells(line, head.part), columns: &head.columns, line: at + 1 }).collect();
    let written: Vec<String> = rows.iter().map(|row| row.cell("name").unwrap_or_default().to_owned()).collect();
    let mut frames = Vec::with_capacity(rows.len());
    for (row, name) in rows.iter().zip(names::settled(&written, photographs)?) {
        let fault = |why| Error::malformed(file, format!("line {}: {why}", row.line));
        let (pose, focal, point, projection) = row.parts().map_err(fault)?;
        let camera = Arc::new(lens::camera(photographs.size(&name)?, focal, point, projection).map_err(fault)?);
        frames.push(Frame { name, camera, pose });
    }
    Ok(frames.into())
}

struct Row<'a> {
    cells: Vec<&'a str>,
    columns: &'a BTreeMap<String, usize>,
    line: usize,
}

impl Row<'_> {
    fn cell(&self, name: &str) -> Option<&str> {
        self.columns.get(name).and_then(|at| self.cells.get(*at)).copied()
    }

    /// The number in a column; 0 where the table has no such column.
    fn number(&self, name: &str) -> Result<f64, String> {
        if !self.columns.contains_key(name) {
            return Ok(0.0);
        }
        let cell = self.cell(name).ok_or_else(|| format!("column {name} is missing"))?;
        let value: f64 = words::number(cell, name)?;
        if value.is_finite() { Ok(value) } else { Err(format!("{name} is {}; it must be finite", shown(cell))) }
    }

    /// The pose, the focal length, the principal point and the projection.
    fn parts(&self) -> Result<(Pose, f64, DVec2, Projection), String> {
        let of = |name| self.number(name);
        let radians = |name| of(name).map(f64::to_radians);
        let (heading, pitch, roll) = (radians("heading")?, radians("pitch")?, radians("roll")?);
        let to_world = DMat3::from_rotation_z(-heading) * DMat3::from_rotation_x(pitch) * DMat3::from_rotation_y(roll);
        let centre = DVec3::new(of("x")?, of("y")?, of("alt")?);
        let pose = posed::at_centre((to_world * Y_UP).transpose(), centre)?;
        let radial = Distortion::radial([of("k1")?, of("k2")?, of("k3")?, of("k4")?]);
        let projection = Projection::Perspective(Distortion { tangential: [of("t1")?, of("t2")?], ..radial });
        Ok((pose, of("f")?, DVec2::new(of("px")?, of("py")?), projection))
    }
}
