//! What a name in a folder stands for.

use std::fs::File;
use std::io;

/// What a name stands for; a link is not followed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::disk) enum Kind {
    /// A file.
    File,
    /// A folder.
    Folder,
    /// A link, a pipe, a device.
    Other,
}

/// Passes a file on, unless it is a folder, a pipe or a device.
pub(super) fn regular(file: File) -> io::Result<File> {
    if file.metadata()?.is_file() { Ok(file) } else { Err(strange()) }
}

/// The error where a link, a pipe or a device has the name of a file.
pub(super) fn strange() -> io::Error {
    io::Error::new(io::ErrorKind::InvalidInput, "it is no file: gonio follows no link here and opens no device")
}
