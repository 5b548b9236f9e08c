//! The markers before the first scan: the size of the image, and the memory that decoding takes.

use std::io::{self, ErrorKind, Read, Seek};

use crate::codec::images::size::Size;

/// The contents of the markers before the first scan.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(in crate::codec::images) struct Header {
    /// The size of the image.
    pub size: Size,
    /// The samples of a decoded pixel: 1 if grey, else 3.
    pub channels: u64,
    /// The bytes that the decoder holds beside the file and the pixels.
    pub workspace: u64,
}

impl Header {
    /// Reads the markers up to the first scan.
    ///
    /// # Errors
    /// `UnexpectedEof` where the file ends before a scan, `InvalidData` where a scan comes without a frame before it.
    pub(in crate::codec::images) fn read(file: &mut (impl Read + Seek)) -> io::Result<Header> {
        let mut frame: Option<Frame> = None;
        loop {
            let marker = next_marker(file)?;
            // Restarts, start and end of image, and 1 stand alone.
            if matches!(marker, 0x01 | 0xd0..=0xd9) {
                continue;
            }
            let [high, low, first] = bytes(file)?;
            let length = i64::from(u16::from_be_bytes([high, low]));
            match marker {
                // Not Huffman tables, nor the reserved, nor arithmetic conditioning.
                0xc0..=0xcf if !matches!(marker, 0xc4 | 0xc8 | 0xcc) => frame = Some(Frame::read(marker, file)?),
                0xda => {
                    let metadata = file.stream_position()?;
                    let none = || io::Error::new(ErrorKind::InvalidData, "a scan without a frame header");
                    return Ok(frame.ok_or_else(none)?.header(usize::from(first), metadata));
                }
                _ => file.seek_relative((length - 3).max(0))?,
            }
        }
    }
}

/// A component as the frame header names it.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Sampling {
    /// The component's id.
    pub id: u8,
    /// The sampling factor across, 1 to 4.
    pub across: u32,
    /// The sampling factor down, 1 to 4.
    pub down: u32,
}

/// A frame header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Frame {
    /// The size of the image.
    pub size: Size,
    /// Whether coefficients come in several scans.
    pub progressive: bool,
    /// The components.
    pub components: Vec<Sampling>,
}

impl Frame {
    /// Reads the header from behind its first byte, the bits of a sample.
    pub(super) fn read(marker: u8, file: &mut impl Read) -> io::Result<Frame> {
        let [h0, h1, w0, w1, count] = bytes(file)?;
        let side = |bytes| u32::from(u16::from_be_bytes(bytes));
        let size = Size { width: side([w0, w1]), height: side([h0, h1]) };
        let component = |_| {
            let [id, factors, _] = bytes(file)?;
            Ok(Sampling { id, across: (factors >> 4).into(), down: (factors & 15).into() })
        };
        let components = (0..count).map(component).collect::<io::Result<_>>()?;
        Ok(Frame { size, progressive: matches!(marker, 0xc2 | 0xc6 | 0xca | 0xce), components })
    }

    /// The largest sampling factors, across and down.
    pub(super) fn most(&self) -> (u64, u64) {
        let most = |factor: fn(&Sampling) -> u32| self.components.iter().map(factor).max().unwrap_or(1).max(1);
        (most(|c| c.across).into(), most(|c| c.down).into())
    }

    /// The header of a file whose first scan has `scanned` components and comes after `metadata` bytes.
    ///
    /// The decoder holds all coefficients, 2 bytes each, where there are several scans; else those of a row of blocks, which
    /// it also scales up to the grid of the pixels.
    fn header(&self, scanned: usize, metadata: u64) -> Header {
        let Frame { size, progressive, components } = self;
        let (across, down) = self.most();
        let (columns, rows) = (u64::from(size.width).div_ceil(8 * across), u64::from(size.height).div_ceil(8 * down));
        let blocks: u64 = components.iter().map(|c| columns * u64::from(c.across) * rows * u64::from(c.down)).sum();
        let held = *progressive || scanned < components.len();
        let coefficients = if held { blocks * 64 * 2 } else { 0 };
        let row = columns * across * 8 * down * 8 * 2;
        let rows = components.len() as u64 * row * (2 + across * down);
        let channels = if components.len() == 1 { 1 } else { 3 };
        // The decoder copies profiles and previews from the file's head.
        Header { size: *size, channels, workspace: coefficients + rows + 2 * metadata }
    }
}

fn bytes<const N: usize>(file: &mut impl Read) -> io::Result<[u8; N]> {
    let mut found = [0; N];
    file.read_exact(&mut found)?;
    Ok(found)
}

/// The next marker: 0xff, and then any byte but 0 (0xff was coded data) and 0xff (a fill byte).
fn next_marker(file: &mut impl Read) -> io::Result<u8> {
    let mut last = 0;
    loop {
        let [byte] = bytes(file)?;
        if last == 0xff && !matches!(byte, 0 | 0xff) {
            return Ok(byte);
        }
        last = byte;
    }
}
