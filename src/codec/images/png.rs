//! PNG (ISO/IEC 15948, clause 5): the bytes of the chunks before the pixels, before the decoder gathers them.
//!
//! Layout: a signature of 8 bytes, then chunks: length u32, name of 4 bytes, so many bytes, crc u32; big endian. The pixels
//! are in chunks IDAT, one after the other.

use std::io::{self, ErrorKind, Read, Seek};

use super::need::PNG_METADATA;

/// The most chunks before the pixels; programs write ten.
const MOST: u32 = 4096;

/// The bytes of the chunks before the pixels; goes back to the start.
///
/// # Errors
/// `UnexpectedEof` where the file ends before its pixels; `InvalidData`, in words, where the chunks are too many or too long.
pub(super) fn metadata(file: &mut (impl Read + Seek)) -> io::Result<u64> {
    file.rewind()?;
    io::copy(&mut file.by_ref().take(8), &mut io::sink())?;
    let mut all = 0;
    for _ in 0..MOST {
        let mut head = [0; 8];
        file.read_exact(&mut head)?;
        let [l0, l1, l2, l3, name @ ..] = head;
        if name == *b"IDAT" {
            file.rewind()?;
            return Ok(all);
        }
        let length = u32::from_be_bytes([l0, l1, l2, l3]);
        all += u64::from(length);
        if all > PNG_METADATA {
            return Err(too_much(format!("more than {PNG_METADATA} bytes come before its pixels")));
        }
        file.seek_relative(i64::from(length) + 4)?;
    }
    Err(too_much(format!("more than {MOST} chunks come before its pixels")))
}

fn too_much(words: String) -> io::Error {
    io::Error::new(ErrorKind::InvalidData, words)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    fn found(chunks: &[(&[u8; 4], usize)]) -> Result<u64, ErrorKind> {
        let mut file = b"\x89PNG\r\n\x1a\n".to_vec();
        for (name, length) in chunks {
            file.extend((*length as u32).to_be_bytes());
            file.extend(*name);
            file.extend(vec![0; length + 4]);
        }
        let mut file = Cursor::new(file);
        let found = metadata(&mut file).map_err(|why| why.kind());
        assert!(found.is_err() || file.position() == 0);
        found
    }

    #[test]
    fn what_comes_before_the_pixels_is_counted_before_it_is_held() {
        assert_eq!(found(&[(b"IHDR", 13), (b"iCCP", 3000), (b"IDAT", 10), (b"tEXt", 99)]), Ok(3013));
        assert_eq!(found(&[(b"IHDR", 13), (b"tEXt", 4 << 20), (b"IDAT", 10)]), Err(ErrorKind::InvalidData));
        assert_eq!(found(&[(b"tEXt", 1); 5000]), Err(ErrorKind::InvalidData));
        assert_eq!(found(&[(b"IHDR", 13), (b"tEXt", 3)]), Err(ErrorKind::UnexpectedEof));
        assert_eq!(found(&[]), Err(ErrorKind::UnexpectedEof));
    }
}
