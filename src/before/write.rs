//! The pipeline file of a project's folder.

use std::fs::{self, OpenOptions};
use std::io::Write;
use std::path::{Path, PathBuf};

use super::found::Found;
use crate::base::shown::quoted;
use crate::base::{Error, Result};
use crate::pipeline::{FILE, filled};

/// The path of the pipeline file of a folder, in which there is none yet.
///
/// # Errors
/// There is one.
pub(crate) fn not_there(folder: &Path) -> Result<PathBuf> {
    let file = folder.join(FILE);
    // What is a link to nothing is there, too.
    match fs::symlink_metadata(&file) {
        Ok(_) => Err(Error::invalid(format!(
            "{} is there, and is never overwritten: take it away, or see with --print what would be written",
            file.display()
        ))),
        Err(_) => Ok(file),
    }
}

/// The text of the pipeline file.
pub(crate) fn text(found: &Found) -> String {
    let folder = quoted(&found.root.display().to_string());
    let folder = folder.escape_debug();
    let head = format!(
        "\
# Materials of a scene. `gonio init` wrote this file and set what it found; every key is explained.
#
#     gonio check {folder}      every problem at once
#     gonio plan {folder}       memory, disk and time, before anything starts
#     gonio run {folder}        run it, or go on where it was stopped
#
# Paths are relative to this file. Any key can be set for one call, as --set light.mode=unknown; a path is then relative to
# the current folder. A key that is marked (needed) must be given. Any other key may be left out: then it has its default,
# or, where it is commented out here, none.
"
    );
    filled(&head, &found.values())
}

/// Writes the pipeline file, which must not be there.
///
/// # Errors
/// It is there, or the system refuses.
pub(crate) fn write(file: &Path, text: &str) -> Result<()> {
    let mut to = OpenOptions::new().write(true).create_new(true).open(file).map_err(Error::io("create", file))?;
    let written = to.write_all(text.as_bytes()).and_then(|()| to.sync_all());
    written.map_err(|why| {
        // Half a file would be in the way of the next try.
        fs::remove_file(file).unwrap_or_default();
        Error::io("write", file)(why)
    })
}
