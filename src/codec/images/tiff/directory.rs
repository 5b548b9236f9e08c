//! The claims of the first directory (TIFF 6.0, section 2), before the decoder believes them. It would hold as many
//! values as an entry claims, up to 256 MiB, before it looks for them.
//!
//! ```text
//! header      "II" or "MM", the order of the bytes; 42 u16; position of the directory u32
//! directory   entries u16; each tag u16, type u16, values u32, and 4 bytes: the values or their position
//! ```
//!
//! BigTIFF has the same with wider numbers (Aware Systems, the BigTIFF design, 2007):
//!
//! ```text
//! header      "II" or "MM"; 43 u16; 8 u16; 0 u16; position of the directory u64
//! directory   entries u64; each tag u16, type u16, values u64, and 8 bytes
//! ```

use std::io::{self, Read, Seek, SeekFrom};

/// The most values of an entry: an image of 65,535 rows has as many strips. Entries that are not needed to decode the
/// image, such as profiles, may have more.
const MOST: u64 = 1 << 16;

/// Tags from here on are not needed to decode the image.
const OPTIONAL: u16 = 700;

/// Checks the first directory of a file and goes back to the start.
///
/// # Errors
/// `UnexpectedEof` where the file ends before the directory does; `InvalidData`, in words, for an entry that claims more
/// values than any image needs.
pub(in crate::codec::images) fn check(file: &mut (impl Read + Seek)) -> io::Result<()> {
    file.rewind()?;
    let start: [u8; 4] = bytes(file)?;
    let (big_endian, wide) = (start[0] == b'M', is_big(&start));
    let short = |b: [u8; 2]| if big_endian { u16::from_be_bytes(b) } else { u16::from_le_bytes(b) };
    let long = |b: [u8; 4]| if big_endian { u32::from_be_bytes(b) } else { u32::from_le_bytes(b) };
    let longer = |b: [u8; 8]| if big_endian { u64::from_be_bytes(b) } else { u64::from_le_bytes(b) };
    let entries = if wide {
        let _: [u8; 4] = bytes(file)?;
        let at = longer(bytes(file)?);
        file.seek(SeekFrom::Start(at))?;
        longer(bytes(file)?)
    } else {
        let at = long(bytes(file)?);
        file.seek(SeekFrom::Start(at.into()))?;
        short(bytes(file)?).into()
    };
    if entries > u64::from(u16::MAX) {
        return Err(invalid(format!("its directory claims {entries} entries; {} are the most", u16::MAX)));
    }
    for _ in 0..entries {
        let tag = short(bytes(file)?);
        let _: [u8; 2] = bytes(file)?;
        let values = if wide { longer(bytes(file)?) } else { long(bytes(file)?).into() };
        file.seek_relative(if wide { 8 } else { 4 })?;
        if values > MOST && tag < OPTIONAL {
            return Err(invalid(format!("its tag {tag} claims {values} values; {MOST} are the most")));
        }
    }
    // The last entry must be whole.
    file.seek_relative(-1)?;
    let _: [u8; 1] = bytes(file)?;
    file.rewind()
}

/// Whether a file begins as a BigTIFF does.
pub(in crate::codec::images) fn is_big(start: &[u8]) -> bool {
    start.starts_with(b"II+\0") || start.starts_with(b"MM\0+")
}

fn invalid(words: String) -> io::Error {
    io::Error::new(io::ErrorKind::InvalidData, words)
}

fn bytes<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut found = [0; N];
    file.read_exact(&mut found)?;
    Ok(found)
}

#[cfg(test)]
mod tests {
    use std::io::Cursor;

    use super::*;

    /// A file whose directory has one entry, in both orders of bytes.
    fn files(tag: u16, values: u32) -> [Vec<u8>; 2] {
        let little = [&b"II"[..], &42u16.to_le_bytes(), &8u32.to_le_bytes(), &1u16.to_le_bytes()].concat();
        let big = [&b"MM"[..], &42u16.to_be_bytes(), &8u32.to_be_bytes(), &1u16.to_be_bytes()].concat();
        [
            [&little[..], &tag.to_le_bytes(), &4u16.to_le_bytes(), &values.to_le_bytes(), &[0; 4]].concat(),
            [&big[..], &tag.to_be_bytes(), &4u16.to_be_bytes(), &values.to_be_bytes(), &[0; 4]].concat(),
        ]
    }

    #[test]
    fn a_tag_that_claims_millions_of_values_is_refused_before_they_are_held() {
        for (tag, values, good) in
            [(273, 1 << 16, true), (273, (1 << 16) + 1, false), (258, u32::MAX, false), (34_675, u32::MAX, true)]
        {
            for file in files(tag, values) {
                let mut file = Cursor::new(file);
                let found = check(&mut file);
                assert_eq!(found.is_ok(), good, "{tag} {values}: {found:?}");
                assert!(!good || file.position() == 0);
            }
        }
    }

    #[test]
    fn every_cut_is_the_end_of_the_file() {
        for file in files(273, 1) {
            for length in 0..file.len() {
                let why = check(&mut Cursor::new(&file[..length])).unwrap_err();
                assert_eq!(why.kind(), io::ErrorKind::UnexpectedEof, "{length}");
            }
        }
    }
}
