//! OpenEXR: the layer that has R, G and B, or Y alone, on the grid of the display window, one block at a time.

use std::io::{self, BufRead, ErrorKind, Read, Seek};
use std::ops::Range;

use exr::compression::Compression;
use exr::error::Error;
use exr::image::read::read;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::meta::header::Header as Layer;
use exr::prelude::{ReadChannels, ReadLayers, ReadSpecificChannel, Text};

use super::size::Size;

/// The most bytes of a header; programs write a few hundred, and previews of tens of thousands. An attribute of a few bytes
/// becomes a thousand in memory.
const LONGEST: u64 = 1 << 17;

/// The bytes that the decoder holds for each block, to read the blocks in the order of the file: 82 were measured.
const BLOCK: u64 = 96;

/// The bytes of the tables of the compression PIZ: 1.2 MB were measured.
const PIZ: u64 = 2 << 20;

/// The contents of the header.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) struct Header {
    /// The size of the display window.
    pub size: Size,
    /// The bytes that the decoder holds beside the pixels.
    pub workspace: u64,
    /// Whether pixels may be missing: there is alpha, or the layer does not fill the display window.
    pub masked: bool,
    /// What comes before the names of the layer's channels, as `diffuse.`.
    prefix: String,
    /// Whether the layer has the one channel Y, not R, G and B.
    grey: bool,
    /// The position of the layer's first pixel in the display window.
    offset: Vec2<i32>,
}

impl Header {
    /// Reads the header.
    ///
    /// # Errors
    /// The system's; `InvalidData` for those of the decoder and for a file without an RGB layer.
    pub(super) fn read(file: &mut impl Read) -> io::Result<Header> {
        let damaged = |found: String| io::Error::new(ErrorKind::InvalidData, found);
        // The decoder gathers attributes of any length.
        let meta = MetaData::read_from_buffered(file.take(LONGEST), false).map_err(|why| match why {
            Error::Io(why) if why.raw_os_error().is_some() => why,
            why => damaged(format!("its header is damaged, or longer than {LONGEST} bytes: {why}")),
        })?;
        Header::of(&meta).map_err(damaged)
    }

    fn of(meta: &MetaData) -> Result<Header, String> {
        let (layer, prefix, grey) = chosen(meta)?;
        let window = layer.shared_attributes.display_window;
        let side = |side: usize| u32::try_from(side).map_err(|_| "the display window is too large".to_owned());
        // A block is held as the file has it, decompressed, and as samples.
        let block = meta.headers.iter().map(block).max().unwrap_or(0);
        let blocks: u64 = meta.headers.iter().map(|h| h.chunk_count as u64).sum();
        let tables = if meta.headers.iter().any(|h| h.compression == Compression::PIZ) { PIZ } else { 0 };
        let workspace = block.saturating_mul(4).saturating_add(blocks.saturating_mul(BLOCK)).saturating_add(tables);
        let size = Size { width: side(window.size.width())?, height: side(window.size.height())? };
        let offset = layer.own_attributes.layer_position - window.position;
        let masked = has(layer, &format!("{prefix}A")) || !fills_window(layer, offset);
        Ok(Header { size, workspace, masked, prefix, grey, offset })
    }
}

/// The most bytes of a block of a layer, whatever sides its tiles have.
fn block(layer: &Layer) -> u64 {
    let Vec2(width, height) = layer.max_block_pixel_size();
    (width as u64).saturating_mul(height as u64).saturating_mul(layer.channels.bytes_per_pixel as u64)
}

/// Whether a layer at this position in its display window fills it.
fn fills_window(layer: &Layer, offset: Vec2<i32>) -> bool {
    let fills =
        |offset: i32, side: usize, window: usize| offset <= 0 && i64::from(offset) + side as i64 >= window as i64;
    let (side, window) = (layer.layer_size, layer.shared_attributes.display_window.size);
    fills(offset.x(), side.width(), window.width()) && fills(offset.y(), side.height(), window.height())
}

fn has(layer: &Layer, name: &str) -> bool {
    layer.channels.list.iter().any(|channel| channel.name == *name)
}

/// The most channels that are listed where none will do.
const LISTED: usize = 24;

/// The layer that is read, what comes before the names of its channels, and whether it is grey. Plain names come first.
fn chosen(meta: &MetaData) -> Result<(&Layer, String, bool), String> {
    let flat = || meta.headers.iter().filter(|layer| !layer.deep);
    let ending = |last: &str| -> Vec<(&Layer, String)> {
        let named = flat().flat_map(|layer| layer.channels.list.iter().map(move |c| (layer, c.name.to_string())));
        let prefix =
            |name: &str| name.strip_suffix(last).filter(|p| p.is_empty() || p.ends_with('.')).map(str::to_owned);
        named.filter_map(|(layer, name)| Some((layer, prefix(&name)?))).collect()
    };
    for (first, others, grey) in [("R", &["G", "B"][..], false), ("Y", &[], true)] {
        let mut found = ending(first);
        // The decoder takes the first layer that has the first channel.
        let is_first =
            |layer: &Layer, name: &str| flat().find(|l| has(l, name)).is_some_and(|l| std::ptr::eq(l, layer));
        found.retain(|(layer, prefix)| {
            is_first(layer, &format!("{prefix}{first}")) && others.iter().all(|c| has(layer, &format!("{prefix}{c}")))
        });
        if grey && found.iter().any(|(layer, prefix)| has(layer, &format!("{prefix}RY"))) {
            return Err("it has luminance and chroma (Y, RY and BY), which are not read: write R, G and B".to_owned());
        }
        if grey && found.iter().any(|(layer, prefix)| ["X", "Z"].iter().all(|c| has(layer, &format!("{prefix}{c}")))) {
            return Err("it has the colours of CIE (X, Y and Z), which are not read: write R, G and B".to_owned());
        }
        let plain = found.iter().position(|(_, prefix)| prefix.is_empty());
        match (plain, &found[..]) {
            (Some(at), _) => return Ok((found[at].0, String::new(), grey)),
            (None, [(layer, prefix)]) => return Ok((layer, prefix.clone(), grey)),
            (None, []) => {}
            (None, several) => {
                let names: Vec<&str> = several.iter().take(LISTED).map(|(_, p)| p.trim_end_matches('.')).collect();
                let words = format!("{} of its layers are pictures: {}", several.len(), names.join(", "));
                return Err(format!("{words}; write the photograph's channels as R, G and B"));
            }
        }
    }
    let names: Vec<String> = flat().flat_map(|h| h.channels.list.iter().map(|c| c.name.to_string())).collect();
    let more = if names.len() > LISTED { ", ..." } else { "" };
    let listed = names[..names.len().min(LISTED)].join(", ");
    Err(format!("no layer has the channels R, G and B; these are there: {listed}{more}"))
}

/// The red of a pixel that no block has written: a number that no file holds.
const UNWRITTEN: f32 = f32::from_bits(0x7fd1_5ea5);

/// Decodes the samples of a file with this header: three `CHANNELS` are RGB, four are RGB and alpha. Pixels outside the
/// layer are 0, alpha included.
///
/// # Errors
/// In words: those of the decoder; blocks that are missing.
pub(super) fn decode<const CHANNELS: usize>(file: impl BufRead + Seek, header: &Header) -> Result<Vec<f32>, String> {
    let Header { size: Size { width, height }, offset, grey, .. } = *header;
    let named = |channel: &str| Text::from(format!("{}{channel}", header.prefix).as_str());
    let [first, second, third] = if grey { ["Y", "no G", "no B"] } else { ["R", "G", "B"] }.map(named);
    let place = move |at: Vec2<usize>| {
        let (x, y) = (within(at.x(), offset.x(), width)?, within(at.y(), offset.y(), height)?);
        Some(CHANNELS * (y * width as usize + x))
    };
    // The decoder reads as many blocks as there must be, and does not mind which. A layer may be far larger than the window.
    let unwritten = move |layer: Vec2<usize>| {
        let mut pixels = vec![0f32; CHANNELS * width as usize * height as usize];
        for y in overlap(offset.y(), layer.height(), height) {
            for x in overlap(offset.x(), layer.width(), width) {
                pixels[CHANNELS * (y * width as usize + x)] = UNWRITTEN;
            }
        }
        pixels
    };
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .specific_channels()
        .required(first)
        .optional(second, 0.0)
        .optional(third, 0.0)
        .optional(named("A"), 1.0)
        .collect_pixels(
            move |layer, _| unwritten(layer),
            move |pixels: &mut Vec<f32>, at, (r, g, b, a): (f32, f32, f32, f32)| {
                let (g, b) = if grey { (r, r) } else { (g, b) };
                if let Some(first) = place(at) {
                    pixels[first..first + CHANNELS].copy_from_slice(&[r, g, b, a][..CHANNELS]);
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        // Frames are read by as many threads as there are; a pool in each would hold a block a thread.
        .non_parallel()
        .from_buffered(file)
        .map_err(words)?;
    let pixels = image.layer_data.channel_data.pixels;
    if pixels.iter().step_by(CHANNELS).any(|red| red.to_bits() == UNWRITTEN.to_bits()) {
        return Err("the EXR lacks some of its blocks".to_owned());
    }
    Ok(pixels)
}

/// What a layer covers along a side of the display window.
fn overlap(offset: i32, layer: usize, side: u32) -> Range<usize> {
    let inside = |at: i64| usize::try_from(at.clamp(0, side.into())).unwrap_or(0);
    let (first, layer) = (i64::from(offset), i64::try_from(layer).unwrap_or(i64::MAX));
    inside(first)..inside(first.saturating_add(layer))
}

/// The position of a layer's sample along a side of the display window; `None` outside.
fn within(at: usize, offset: i32, side: u32) -> Option<usize> {
    let at = i64::try_from(at).ok()?.checked_add(offset.into())?;
    usize::try_from(at).ok().filter(|&at| at < side as usize)
}

fn words(why: Error) -> String {
    match why {
        Error::Io(why) if why.kind() == std::io::ErrorKind::UnexpectedEof => "it is cut short".to_owned(),
        // The table of the blocks leads beyond the end of the file.
        why if why.to_string().ends_with("reference to missing bytes") => "it is cut short".to_owned(),
        why => why.to_string(),
    }
}
