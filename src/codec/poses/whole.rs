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
fn bytes(path: &Path) -> Result<Vec<u8>> {
    let file = Input::open(path).map_err(Error::io("open", path))?;
    if file.length() > LARGEST {
        let (length, largest) = (Bytes(file.length()), Bytes(LARGEST));
        return Err(Error::malformed(path, format!("the file has {length}; at most {largest} are read as poses")));
    }
    file.read_all().map_err(Error::io("read", path))
}

/// The text of a file: UTF-8, or UTF-16 with its byte-order mark. It comes without the mark, and lines that end in CR alone end in
/// LF.
///
/// # Errors
/// Those of [`bytes`]; what is neither UTF-8 nor UTF-16.
pub(super) fn text(path: &Path) -> Result<String> {
    decoded(bytes(path)?).map_err(|why| Error::malformed(path, why))
}

/// The text that bytes are.
fn decoded(bytes: Vec<u8>) -> Result<String, String> {
    let text = match wide(&bytes) {
        Some(text) => text,
        None => String::from_utf8(bytes).map_err(|why| {
            let at = why.utf8_error().valid_up_to();
            format!("byte {at} is no UTF-8: save the file as UTF-8")
        })?,
    };
    Ok(plain(text))
}

/// The text without a byte-order mark, its lines ended by LF where all end in CR alone. Where LF and CR LF end lines, both end in LF.
fn plain(mut text: String) -> String {
    if text.starts_with('\u{feff}') {
        text.drain(..'\u{feff}'.len_utf8());
    }
    if text.contains('\r') && !text.contains('\n') { text.replace('\r', "\n") } else { text }
}

/// The text of UTF-16, which its byte-order mark tells; what is none stands as a replacement character.
fn wide(bytes: &[u8]) -> Option<String> {
    let of: fn([u8; 2]) -> u16 = match bytes {
        [0xff, 0xfe, ..] => u16::from_le_bytes,
        [0xfe, 0xff, ..] => u16::from_be_bytes,
        _ => return None,
    };
    let units = bytes.as_chunks::<2>().0.iter().map(|pair| of(*pair));
    Some(char::decode_utf16(units).map(|c| c.unwrap_or(char::REPLACEMENT_CHARACTER)).collect())
}

/// The text at the start of a file, as [`text`] has it; nothing if it cannot be read.
pub(super) fn start_text(path: &Path, most: u64) -> String {
    let bytes = start(path, most);
    // The last letter may be cut.
    plain(wide(&bytes).unwrap_or_else(|| String::from_utf8_lossy(&bytes).into_owned()))
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

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn texts_are_read_as_editors_and_systems_save_them() {
        let dir = tempfile::tempdir().unwrap();
        let file = dir.path().join("a.txt");
        let wide =
            |units: &mut dyn Iterator<Item = u16>, of: fn(u16) -> [u8; 2]| units.flat_map(of).collect::<Vec<u8>>();
        let marked = "\u{feff}one\ntw\u{f6}\n";
        for bytes in [
            b"one\ntw\xc3\xb6\n".to_vec(),
            marked.as_bytes().to_vec(),
            b"one\rtw\xc3\xb6\r".to_vec(),
            wide(&mut marked.encode_utf16(), u16::to_le_bytes),
            wide(&mut marked.encode_utf16(), u16::to_be_bytes),
        ] {
            std::fs::write(&file, &bytes).unwrap();
            assert_eq!(text(&file).unwrap(), "one\ntw\u{f6}\n", "{bytes:?}");
            assert_eq!(start_text(&file, 64), "one\ntw\u{f6}\n", "{bytes:?}");
        }
        std::fs::write(&file, "one\r\ntwo\rthree\n").unwrap();
        assert_eq!(text(&file).unwrap(), "one\r\ntwo\rthree\n");
        std::fs::write(&file, b"one \xe9").unwrap();
        assert!(text(&file).unwrap_err().to_string().contains("byte 4 is no UTF-8: save the file as UTF-8"));
        assert_eq!(start_text(&dir.path().join("nowhere"), 64), "");
    }
}
