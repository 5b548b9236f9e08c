//! A folder that is held open: files are named relative to it, so nobody can put another folder in its place meanwhile,
//! and no link is followed below it. Names are single parts of a path.

use std::fs::File;
use std::io;

#[cfg(not(unix))]
mod elsewhere;
#[cfg(unix)]
mod unix;

#[cfg(not(unix))]
pub(super) use elsewhere::{Folder, has_no_links};
#[cfg(unix)]
pub(super) use unix::{Folder, has_no_links};

/// What a name stands for; a link is not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Kind {
    /// A file.
    File,
    /// A folder.
    Folder,
    /// A link, a pipe, a device.
    Other,
}

/// Passes a file on, unless it is a folder, a pipe or a device.
fn regular(file: File) -> io::Result<File> {
    if file.metadata()?.is_file() { Ok(file) } else { Err(strange()) }
}

/// The error where a link, a pipe or a device has the name of a file.
fn strange() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, "it is no file: gonio follows no link here and opens no device")
}
