//! Files that are read as a whole: JSON, XML and short texts.

use std::path::Path;

use crate::base::input::Input;
use crate::base::units::Bytes;
use crate::base::{Error, Result};

/// The largest file: a reconstruction with some ten million points.
const LARGEST: u64 = 2 << 30;

/// The bytes of a file.
///
/// # Errors
/// A file that cannot be read, or beyond 2 GiB.
pub(super) fn bytes(path: &Path) -> Result<Vec<u8>> {
    let file = Input::open(path).map_err(Error::io("open", path))?;
    if file.length() > LARGEST {
        let (length, largest) = (Bytes(file.length()), Bytes(LARGEST));
        return Err(Error::malformed(path, format!("the file has {length}; at most {largest} are read as poses")));
    }
    file.read_all().map_err(Error::io("read", path))
}

/// The text of a file, without a byte-order mark.
///
/// # Errors
/// Those of [`bytes`]; what is not UTF-8.
pub(super) fn text(path: &Path) -> Result<String> {
    let text = String::from_utf8(bytes(path)?);
    let text = text.map_err(|why| {
        let at = why.utf8_error().valid_up_to();
        Error::malformed(path, format!("byte {at} is no UTF-8: save the file as UTF-8"))
    })?;
    Ok(text.strip_prefix('\u{feff}').map_or_else(|| text.clone(), str::to_owned))
}

/// The first bytes of a file; none if it cannot be read.
pub(super) fn start(path: &Path, most: u64) -> Vec<u8> {
    let mut start = Vec::new();
    if let Ok(file) = Input::open(path)
        && std::io::Read::read_to_end(&mut std::io::Read::take(file, most), &mut start).is_err()
    {
        start.clear();
    }
    start
}
