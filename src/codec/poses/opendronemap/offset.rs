//! The offset of georeferenced meshes: `odm_georeferencing_model_geo.txt`, or the head of `coords.txt`.
//!
//! ```text
//! WGS84 UTM 16N
//! 482706.6988473 1557461.3955058        east and north
//! ```

use std::path::Path;

use glam::DVec3;

use crate::base::{Error, Result};
use crate::codec::poses::whole;
use crate::codec::poses::words::exactly;

/// Where the coordinates of the meshes begin.
#[derive(Debug, Clone, PartialEq)]
pub(super) struct Offset {
    /// East, north and 0, metres.
    pub at: DVec3,
    /// The projection, as the file names it.
    pub projection: String,
}

/// The files that hold it.
const FILES: [&str; 2] = ["odm_georeferencing_model_geo.txt", "coords.txt"];

/// The offset of a project; `None` where it is not georeferenced.
///
/// # Errors
/// A file that cannot be read; a second line that is not two numbers.
pub(super) fn read(project: &Path) -> Result<Option<Offset>> {
    let folder = project.join("odm_georeferencing");
    let Some(file) = FILES.iter().map(|name| folder.join(name)).find(|file| file.is_file()) else { return Ok(None) };
    let text = whole::text(&file)?;
    let mut lines = text.lines();
    let (projection, offset) = (lines.next().unwrap_or_default(), lines.next().unwrap_or_default());
    let [east, north] = exactly(offset, "the offset (line 2)").map_err(|why| Error::malformed(&file, why))?;
    Ok(Some(Offset { at: DVec3::new(east, north, 0.0), projection: projection.trim().to_owned() }))
}
