//! Whether a JPEG is whole: whether every block of every scan is there. A decoder puts grey, or whatever comes, in the place of
//! what is missing or damaged, and says nothing; that must not count as radiance.

use std::ops::Range;

use super::header::{Frame, Sampling};
use super::huffman::Table;
use super::junk::Junk;
use super::scan::{Component, Defined, NEVER, Scan};
use crate::base::convert::{to_u32, to_usize};
use crate::codec::images::size::Size;

/// What of a whole JPEG a decoder need not see.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Spare {
    /// The bytes before the end that belong to nothing, ascending.
    pub junk: Vec<Range<usize>>,
    /// The position of the marker that ends the image, or of what is in its place.
    pub end: usize,
}

/// Goes through all markers (T.81, annex B) and all coded data of an image of this size.
///
/// # Errors
/// In words: what is missing or damaged.
pub(super) fn check(file: &[u8], size: Size) -> Result<Spare, String> {
    let mut walk =
        Walk { junk: Junk { file, found: Vec::new() }, defined: Defined::default(), image: None, coded: false };
    let mut at = 2;
    loop {
        let (found, code) = walk.junk.skip(at, walk.coded)?;
        let segment = file.get(found + 2..).and_then(|rest| {
            let length = u16::from_be_bytes(*rest.first_chunk::<2>()?);
            rest.get(2..usize::from(length))
        });
        at = match (code, segment) {
            // Restarts, start of image, and 1 stand alone, and mean nothing here.
            (Some(0x01 | 0xd0..=0xd8), _) => {
                walk.junk.found.push(found..found + 2);
                found + 2
            }
            (None | Some(0xd9), _) | (_, None) => return walk.ended(found),
            (Some(code), Some(segment)) => walk.segment(code, segment, found + 4 + segment.len(), size)?,
        };
    }
}

struct Walk<'a> {
    junk: Junk<'a>,
    defined: Defined,
    image: Option<Image>,
    /// Whether coded data have come.
    coded: bool,
}

/// A frame, and what has been sent of it.
struct Image {
    progressive: bool,
    /// Columns and rows of units where components are interleaved.
    units: (u32, u32),
    components: Vec<Component>,
    /// Scans so far.
    scans: u32,
    /// Whether the decoder gets the image wrong, and says nothing, if it has more than one scan: where components of several
    /// scans are not coded progressively, it minds neither restarts nor rows that are scaled nor pairs of components.
    one_scan_only: bool,
}

impl Walk<'_> {
    /// Takes a segment that ends at `end`, and gives the position behind what belongs to it.
    fn segment(&mut self, code: u8, segment: &[u8], end: usize, size: Size) -> Result<usize, String> {
        match code {
            0xc4 => self.define(segment)?,
            0xc8 | 0xcc => {}
            0xc0..=0xc2 => self.begin(code, segment, size)?,
            0xc3..=0xcf => {
                return Err(format!(
                    "the JPEG is coded by process {} of its standard, and gonio reads 0, 1 and 2",
                    code - 0xc0
                ));
            }
            0xdd => {
                let units = segment
                    .first_chunk::<2>()
                    .ok_or("the JPEG is damaged: the interval of its restarts is cut short")?;
                self.defined.interval = u16::from_be_bytes(*units).into();
            }
            0xda => {
                let image = self.image.as_mut().ok_or("the JPEG is damaged: a scan without a frame header")?;
                let scan = Scan::read(segment, &image.components, image.progressive)?;
                scan.send(&mut image.components)?;
                image.scans += 1;
                image.one_scan_only |= self.defined.interval > 0 || !scan.is_alone();
                self.coded = true;
                return scan.pass(end, &mut image.components, &self.defined, image.units, &mut self.junk);
            }
            _ => {}
        }
        Ok(end)
    }

    fn define(&mut self, segment: &[u8]) -> Result<(), String> {
        let mut rest = segment;
        while let Some((&place, table)) = rest.split_first() {
            let (table, after) = Table::read(table).ok_or("the JPEG is damaged: a Huffman table is none")?;
            let all = if place >> 4 == 0 { &mut self.defined.dc } else { &mut self.defined.ac };
            *all.get_mut(usize::from(place & 15))
                .ok_or("the JPEG is damaged: a Huffman table has a number above 3")? = Some(table);
            rest = after;
        }
        Ok(())
    }

    fn begin(&mut self, code: u8, segment: &[u8], size: Size) -> Result<(), String> {
        if self.image.is_some() {
            return Err("the JPEG is damaged: a second frame header comes before the end".to_owned());
        }
        let mut rest = segment.get(1..).unwrap_or_default();
        let frame = Frame::read(code, &mut rest).map_err(|_| "the JPEG is damaged: the frame header is cut short")?;
        // IMPORTANT: memory was set aside for an image of this size.
        if frame.size != size {
            return Err(format!("it has changed since its header was read: it has {} pixels now", frame.size));
        }
        self.image = Some(Image::new(&frame)?);
        Ok(())
    }

    fn ended(self, end: usize) -> Result<Spare, String> {
        let image = self.image.ok_or("the JPEG is cut short within its header")?;
        if image.components.iter().any(|component| component.sent != [0; 64]) {
            return Err("the JPEG is cut short: some of its scans are missing".to_owned());
        }
        if !image.progressive && image.scans > 1 && image.one_scan_only {
            let words = "the JPEG has its components in several scans in a way that gonio does not read: write it anew with one \
                         scan, or as a progressive file";
            return Err(words.to_owned());
        }
        let mut junk = self.junk.found;
        // What is in the place of an end that is missing belongs to nothing, too.
        junk.retain(|bytes| bytes.start < end);
        Ok(Spare { junk, end })
    }
}

impl Image {
    fn new(frame: &Frame) -> Result<Image, String> {
        let in_range = |factor: u32| (1..=4).contains(&factor);
        if !frame.components.iter().all(|part| in_range(part.across) && in_range(part.down)) {
            return Err("the JPEG is damaged: a sampling factor is not 1 to 4".to_owned());
        }
        let (across, down) = frame.most();
        let blocks = |pixels: u32, factor: u32, most: u64| {
            to_u32(to_usize((u64::from(pixels) * u64::from(factor)).div_ceil(8 * most)))
        };
        let Size { width, height } = frame.size;
        let component = |part: &Sampling| {
            let blocks = (blocks(width, part.across, across), blocks(height, part.down, down));
            let there = if frame.progressive { vec![0; blocks.0 as usize * blocks.1 as usize] } else { Vec::new() };
            Component { id: part.id, unit: part.across * part.down, blocks, sent: [NEVER; 64], there }
        };
        let units = (blocks(width, 1, across), blocks(height, 1, down));
        let components = frame.components.iter().map(component).collect();
        let scaled = frame.components.iter().any(|part| part.down > 1);
        Ok(Image { progressive: frame.progressive, units, components, scans: 0, one_scan_only: scaled })
    }
}
