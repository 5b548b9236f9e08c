//! The table of a registration. The first line names the columns:
//!
//! ```text
//! #name,x,y,alt,heading,pitch,roll,f,px,py,k1,k2,k3,k4,t1,t2
//! ```
//!
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

/// Whether a file that begins so is such a table.
pub(super) fn is_one(start: &[u8]) -> bool {
    let text = String::from_utf8_lossy(start);
    columns(text.lines().next().unwrap_or_default()).is_ok()
}

/// The position of each column.
type Columns<'a> = BTreeMap<&'a str, usize>;

fn columns(head: &str) -> Result<Columns<'_>, String> {
    let head = head.trim_start_matches('\u{feff}').trim_start_matches('#');
    let columns: Columns<'_> = head.split(',').enumerate().map(|(at, name)| (name.trim(), at)).collect();
    match NEEDED.iter().find(|name| !columns.contains_key(*name)) {
        Some(missing) => Err(format!("line 1 names no column {missing}; {} are needed", NEEDED.join(", "))),
        None => Ok(columns),
    }
}

/// Reads a table.
///
/// # Errors
/// A file that cannot be read, a line that is not as the first says, an image whose size cannot be read.
pub(super) fn read(file: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let text = whole::text(file)?;
    let columns = columns(text.lines().next().unwrap_or_default()).map_err(|why| Error::malformed(file, why))?;
    let mut rows = Vec::new();
    for (at, line) in text.lines().enumerate().skip(1).filter(|(_, line)| !line.trim().is_empty()) {
        let row = Row { cells: line.split(',').map(str::trim).collect(), columns: &columns, line: at + 1 };
        rows.push(row);
    }
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
    columns: &'a Columns<'a>,
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
