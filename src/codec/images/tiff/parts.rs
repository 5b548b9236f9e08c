//! The strips or tiles of a TIFF.

use std::io::{Cursor, ErrorKind};

use tiff::decoder::{ChunkType, Decoder};
use tiff::tags::Tag;
use tiff::{TiffError, TiffResult};

use super::coded::{Coding, Needs, check_part};
use crate::base::convert::to_usize;

/// Checks that all strips or tiles of the first image are there and hold all their rows.
///
/// # Errors
/// In words: what is missing or damaged, or what the decoder says of the directory.
pub(in crate::codec::images) fn check_parts(file: &[u8]) -> Result<(), String> {
    let parts = Parts::read(file).map_err(|why| match why {
        TiffError::IoError(why) if why.kind() == ErrorKind::UnexpectedEof => "the TIFF is cut short".to_owned(),
        why => why.to_string(),
    })?;
    let (count, noun) = (parts.count(), if parts.tiled { "tile" } else { "strip" });
    if (parts.ranges.len() as u64) < count {
        return Err(format!("the TIFF is cut short: it has {} of {count} {noun}s", parts.ranges.len()));
    }
    for (number, &(start, length)) in (0..count).zip(&parts.ranges) {
        let which = || format!("{noun} {number} of {count}");
        if start == 0 || length == Some(0) {
            return Err(format!("the TIFF lacks {}", which()));
        }
        let needs = parts.needs(number);
        let end = start.checked_add(length.unwrap_or(needs.rows)).filter(|&end| end <= file.len() as u64);
        let end = end.ok_or_else(|| format!("the TIFF is cut short: {} goes past its end", which()))?;
        let found = check_part(&file[to_usize(start)..to_usize(end)], needs, &parts.coding);
        found.map_err(|why| format!("the TIFF is damaged: {} {why}", which()))?;
    }
    Ok(())
}

struct Parts {
    /// Whether the parts are tiles, not strips.
    tiled: bool,
    /// Columns and rows of the image.
    image: (u32, u32),
    /// Columns and rows of a part.
    part: (u32, u32),
    /// The planes that come one after the other.
    planes: u32,
    /// The bits of a pixel in a part.
    bits: u64,
    coding: Coding,
    /// Where each part lies: the first byte, and the length where there is one.
    ranges: Vec<(u64, Option<u64>)>,
}

impl Parts {
    fn read(file: &[u8]) -> TiffResult<Parts> {
        let mut decoder = Decoder::new(Cursor::new(file))?;
        let (image, part) = (decoder.dimensions()?, decoder.chunk_dimensions());
        let tiled = decoder.get_chunk_type() == ChunkType::Tile;
        let (starts, lengths) = match tiled {
            true => (Tag::TileOffsets, Tag::TileByteCounts),
            false => (Tag::StripOffsets, Tag::StripByteCounts),
        };
        let mut number = |tag, usual| -> TiffResult<u32> { Ok(decoder.find_tag_unsigned(tag)?.unwrap_or(usual)) };
        let samples = number(Tag::SamplesPerPixel, 1)?;
        let planes = if number(Tag::PlanarConfiguration, 1)? == 2 { samples.max(1) } else { 1 };
        let compression = number(Tag::Compression, 1)?;
        let bits = decoder.find_tag_unsigned_vec::<u32>(Tag::BitsPerSample)?;
        let bits = bits.and_then(|bits| bits.first().copied()).unwrap_or(1);
        let coding = Coding::read(compression, &mut decoder)?;
        let starts = decoder.get_tag_u64_vec(starts)?;
        let lengths = decoder.find_tag(lengths)?.map(|found| found.into_u64_vec()).transpose()?;
        // Where nothing is compressed, the lengths may be left out.
        let length = |at: usize| lengths.as_ref().map(|lengths| lengths.get(at).copied().unwrap_or(0));
        let ranges = starts.iter().enumerate().map(|(at, &start)| (start, length(at))).collect();
        let bits = u64::from(samples / planes) * u64::from(bits);
        Ok(Parts { tiled, image, part, planes, bits, coding, ranges })
    }

    /// The parts of a plane, across and down.
    fn grid(&self) -> (u64, u64) {
        let count = |all: u32, each: u32| u64::from(all).div_ceil(each.max(1).into());
        (count(self.image.0, self.part.0), count(self.image.1, self.part.1))
    }

    /// The number of parts.
    fn count(&self) -> u64 {
        let (across, down) = self.grid();
        (across * down).saturating_mul(self.planes.into())
    }

    fn needs(&self, number: u64) -> Needs {
        let (across, down) = self.grid();
        let row = (u64::from(self.part.0) * self.bits).div_ceil(8);
        let (all, each) = (u64::from(self.image.1), u64::from(self.part.1));
        // A tile is whole; the last strip ends with the image, or is filled up.
        let above = number % (across * down).max(1) / across.max(1) * each;
        let rows = if self.tiled { each } else { all.saturating_sub(above).min(each) };
        Needs { rows: row.saturating_mul(rows), most: row.saturating_mul(each) }
    }
}
