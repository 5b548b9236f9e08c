//! One strip or tile as it is coded.

use std::io::{self, Read, Seek};

use flate2::read::ZlibDecoder;
use tiff::TiffResult;
use tiff::decoder::Decoder;
use tiff::tags::Tag;
use weezl::decode::Configuration;
use weezl::{BitOrder, LzwStatus};

use crate::base::convert::to_usize;
use crate::codec::images::jpeg;

/// The compression of a TIFF.
pub(super) enum Coding {
    /// No compression.
    Plain,
    /// LZW, as TIFF 6.0 has it.
    Lzw,
    /// Deflate in a zlib stream, which has a checksum.
    Deflate,
    /// Runs of bytes.
    PackBits,
    /// JPEG; the tables that all parts share come first.
    Jpeg(Vec<u8>),
    /// Another one.
    Other,
}

/// The bytes that may be left over of a part: the end of its codes, and what fills it up.
const FEW: usize = 8;

/// Bytes that are decoded at once.
const BUFFER: usize = 1 << 15;

impl Coding {
    /// The coding of this number.
    pub(super) fn read<R: Read + Seek>(number: u32, decoder: &mut Decoder<R>) -> TiffResult<Self> {
        Ok(match number {
            1 => Coding::Plain,
            5 => Coding::Lzw,
            8 | 0x80b2 => Coding::Deflate,
            0x8005 => Coding::PackBits,
            7 => {
                let tables = decoder.find_tag(Tag::JPEGTables)?.map(|found| found.into_u8_vec()).transpose()?;
                Coding::Jpeg(tables.unwrap_or_default())
            }
            _ => Coding::Other,
        })
    }
}

/// What a part amounts to when it is decoded.
#[derive(Debug, Clone, Copy)]
pub(super) struct Needs {
    /// The bytes of its rows.
    pub rows: u64,
    /// The bytes of as many rows as a part may have.
    pub most: u64,
}

/// Checks that a part holds all its rows.
///
/// # Errors
/// In words: what is wrong with it.
pub(super) fn check_part(part: &[u8], needs: Needs, coding: &Coding) -> Result<(), String> {
    let found = part.len() as u64;
    let left = match coding {
        Coding::Plain => return if found >= needs.rows { Ok(()) } else { Err(short(found, needs.rows)) },
        Coding::Jpeg(tables) => {
            return jpeg::check(&joined(tables, part)).map_err(|why| format!("does not hold: {why}"));
        }
        Coding::Deflate => return deflate(part, needs),
        Coding::Other => return Ok(()),
        Coding::Lzw => lzw(part, needs)?,
        Coding::PackBits => pack_bits(part, needs)?,
    };
    if left > FEW { Err(format!("has {left} bytes left over after its last row")) } else { Ok(()) }
}

fn short(found: u64, needed: u64) -> String {
    format!("holds {found} bytes, and its rows need {needed}")
}

/// A JPEG of the tables of one, without its end, and the rest of another, without its start.
fn joined(tables: &[u8], part: &[u8]) -> Vec<u8> {
    let tables = tables.strip_suffix(&[0xff, 0xd9]).unwrap_or(tables);
    if tables.is_empty() { part.to_vec() } else { [tables, part.get(2..).unwrap_or_default()].concat() }
}

fn deflate(part: &[u8], needs: Needs) -> Result<(), String> {
    // To the end of the stream, where its checksum is.
    let stream = ZlibDecoder::new(part);
    let found = io::copy(&mut stream.take(needs.most + 1), &mut io::sink());
    match found.map_err(|why| format!("cannot be decompressed: {why}"))? {
        found if found < needs.rows => Err(short(found, needs.rows)),
        found if found > needs.most => Err(format!("holds more than the {} bytes that it may have", needs.most)),
        _ => Ok(()),
    }
}

/// Decompresses, and gives the number of bytes that are left of the part.
fn lzw(part: &[u8], Needs { rows, most }: Needs) -> Result<usize, String> {
    let configuration = Configuration::with_tiff_size_switch(BitOrder::Msb, 8).with_yield_on_full_buffer(true);
    let mut decoder = configuration.build();
    let (mut rest, mut found, mut buffer) = (part, 0, vec![0; BUFFER]);
    while found < most {
        let room = to_usize(most - found).min(BUFFER);
        let done = decoder.decode_bytes(rest, &mut buffer[..room]);
        rest = &rest[done.consumed_in..];
        found += done.consumed_out as u64;
        match done.status {
            Ok(LzwStatus::Ok) => {}
            Ok(_) | Err(_) if found >= rows => break,
            Ok(_) => return Err(short(found, rows)),
            Err(why) => return Err(format!("cannot be decompressed: {why}")),
        }
    }
    Ok(rest.len())
}

/// Goes past the runs, and gives the number of bytes that are left of the part.
fn pack_bits(part: &[u8], Needs { rows, most }: Needs) -> Result<usize, String> {
    let (mut rest, mut found) = (part, 0);
    while found < most {
        let Some((&head, after)) = rest.split_first() else { break };
        let (taken, given) = match head {
            0..=127 => (usize::from(head) + 1, u64::from(head) + 1),
            128 => (0, 0),
            129.. => (1, 257 - u64::from(head)),
        };
        let Some(after) = after.get(taken..) else { break };
        (rest, found) = (after, found + given);
    }
    if found < rows { Err(short(found, rows)) } else { Ok(rest.len()) }
}
