//! Radiance HDR (Ward, "Real Pixels", 1991): the length of its header, before the decoder gathers the header's lines.
//!
//! Layout: lines of text, an empty line, a line with the size, then the pixels.

use std::io::{self, ErrorKind, Read, Seek};

/// The most bytes of the lines before the pixels; programs write a few hundred.
const LONGEST: u64 = 1 << 16;

/// Checks that the header ends, and goes back to the start.
///
/// # Errors
/// `UnexpectedEof` where the file ends before the header does, `InvalidData` where the header is too long.
pub(super) fn check(file: &mut (impl Read + Seek)) -> io::Result<()> {
    let mut start = Vec::new();
    file.rewind()?;
    file.by_ref().take(LONGEST).read_to_end(&mut start)?;
    file.rewind()?;
    // The size ends in the first line break after the empty line.
    let size = start.windows(2).position(|two| two == b"\n\n").map(|at| &start[at + 2..]);
    match size {
        Some(size) if size.contains(&b'\n') => Ok(()),
        _ if (start.len() as u64) < LONGEST => Err(ErrorKind::UnexpectedEof.into()),
        _ => Err(io::Error::new(ErrorKind::InvalidData, format!("its header is longer than {LONGEST} bytes"))),
    }
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    #[test]
    fn a_header_without_end_is_not_gathered() {
        let header = |comment: usize| {
            let text = format!("#?RADIANCE\n# {}\nFORMAT=32-bit_rle_rgbe\n\n-Y 3 +X 5\n", "c".repeat(comment));
            [text.as_bytes(), &[0; 60]].concat()
        };
        let found = |bytes: &[u8]| check(&mut Cursor::new(bytes)).map_err(|why| why.kind());
        assert_eq!(found(&header(10)), Ok(()));
        assert_eq!(found(&header(70_000)), Err(ErrorKind::InvalidData));
        assert_eq!(found(&vec![b'a'; 1 << 20]), Err(ErrorKind::InvalidData));
        let whole = header(10);
        for length in 0..whole.len() - 60 {
            assert_eq!(found(&whole[..length]), Err(ErrorKind::UnexpectedEof), "{length}");
        }
    }
}
