//! OpenEXR: the first layer that has R, G and B, on the display window's grid, one block at a time.

use std::io::{BufReader, Read, Seek};

use exr::error::Error;
use exr::image::read::read;
use exr::math::Vec2;
use exr::meta::MetaData;
use exr::prelude::{ReadChannels, ReadLayers, Text};

/// What the header says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Header {
    /// Columns and rows of the display window.
    pub size: (u32, u32),
    /// Bytes that the decoder holds beside the pixels.
    pub workspace: u64,
    /// Whether the layer has alpha.
    pub alpha: bool,
    /// Where the layer's pixels begin in the display window.
    offset: Vec2<i32>,
}

impl Header {
    /// Reads it.
    ///
    /// # Errors
    /// What the decoder says; a file without an RGB layer.
    pub fn read(file: &mut impl Read) -> Result<Header, String> {
        let meta = MetaData::read_from_buffered(file, false).map_err(words)?;
        let has = |header: &exr::meta::header::Header, name: &str| {
            header.channels.find_index_of_channel(&Text::from(name)).is_some()
        };
        let layer = meta.headers.iter().find(|h| !h.deep && ["R", "G", "B"].iter().all(|name| has(h, name)));
        let layer = layer.ok_or("no layer has the channels R, G and B")?;
        let window = layer.shared_attributes.display_window;
        let side = |side: usize| u32::try_from(side).map_err(|_| "the display window is too large".to_owned());
        // A block is held as it is in the file, decompressed, and as samples.
        let block = meta.headers.iter().map(|h| h.max_block_byte_size() as u64).max().unwrap_or(0);
        let size = (side(window.size.width())?, side(window.size.height())?);
        let offset = layer.own_attributes.layer_position - window.position;
        Ok(Header { size, workspace: 4 * block, alpha: has(layer, "A"), offset })
    }
}

/// Decodes the samples of a file whose header said this: RGB, and alpha too if there are to be four `CHANNELS` and not
/// three. Pixels outside the layer are 0, alpha included.
///
/// # Errors
/// What the decoder says, in words.
pub fn decode<const CHANNELS: usize>(file: BufReader<impl Read + Seek>, header: &Header) -> Result<Vec<f32>, String> {
    let Header { size: (width, height), offset, .. } = *header;
    let samples = CHANNELS * width as usize * height as usize;
    let image = read()
        .no_deep_data()
        .largest_resolution_level()
        .rgba_channels(
            move |_, _| vec![0f32; samples],
            move |pixels: &mut Vec<f32>, at, (r, g, b, a): (f32, f32, f32, f32)| {
                let (x, y) = (at.x() as i64 + i64::from(offset.x()), at.y() as i64 + i64::from(offset.y()));
                if (0..i64::from(width)).contains(&x) && (0..i64::from(height)).contains(&y) {
                    let first = CHANNELS * (y as usize * width as usize + x as usize);
                    pixels[first..first + CHANNELS].copy_from_slice(&[r, g, b, a][..CHANNELS]);
                }
            },
        )
        .first_valid_layer()
        .all_attributes()
        // The workers are the threads; a pool in each would hold a block a thread.
        .non_parallel()
        .from_buffered(file)
        .map_err(words)?;
    Ok(image.layer_data.channel_data.pixels)
}

fn words(why: Error) -> String {
    match why {
        Error::Io(why) if why.kind() == std::io::ErrorKind::UnexpectedEof => "the file ends early".to_owned(),
        why => why.to_string(),
    }
}
