//! Where the bytes of a buffer lie: in the file's own chunk, in a file beside it, or as base64 in its JSON.

use std::io::{self, Read, Seek, SeekFrom};
use std::path::{Component, Path, PathBuf};

use ::gltf::buffer::{Buffer, Source};
use base64::engine::general_purpose::STANDARD;
use base64::read::DecoderReader;

use super::document::Chunk;
use crate::base::convert::to_usize;
use crate::base::input::Input;
use crate::base::shown::shown;
use crate::base::{Error, Result};

/// What begins a buffer that stands in the JSON; its type stands between the two.
const DATA: (&str, &str) = ("data:", ";base64,");

/// Where the bytes of a buffer lie.
#[derive(Debug, Clone)]
pub(super) enum Place<'a> {
    /// In the file itself.
    Own(Chunk),
    /// In a file below the folder of the file.
    Beside(PathBuf),
    /// In the JSON, as base64.
    Within(&'a str),
}

impl<'a> Place<'a> {
    /// Where a buffer lies; `folder` is that of the file.
    ///
    /// # Errors
    /// In words: no chunk, another kind of URI, a path that leads out of the folder.
    pub(super) fn of(buffer: &Buffer<'a>, chunk: Option<Chunk>, folder: &Path) -> Result<Place<'a>, String> {
        match buffer.source() {
            Source::Bin => Ok(Place::Own(chunk.ok_or("the file has no binary chunk")?)),
            Source::Uri(uri) => match uri.strip_prefix(DATA.0) {
                Some(data) => match data.split_once(DATA.1) {
                    Some((_, text)) => Ok(Place::Within(text)),
                    None => Err("its buffer stands in the JSON in another form than base64".to_owned()),
                },
                None => relative(uri).map(|path| Place::Beside(folder.join(path))),
            },
        }
    }

    /// The bytes from an offset on.
    ///
    /// # Errors
    /// The system's; a buffer of fewer bytes than `length`, which is what the JSON says of it.
    pub(super) fn open<'b>(&'b self, file: &'b mut Input, offset: u64, length: u64) -> Result<Box<dyn Read + 'b>> {
        let path = file.path().to_owned();
        let short = |path: &Path, has: u64| {
            Err(Error::malformed(path, format!("a buffer is said to have {length} bytes, and {has} are there")))
        };
        match self {
            Place::Own(chunk) if chunk.length < length => short(&path, chunk.length),
            Place::Own(chunk) => {
                file.seek(SeekFrom::Start(chunk.start + offset)).map_err(Error::io("read", path))?;
                Ok(Box::new(file))
            }
            Place::Beside(path) => {
                let mut other = Input::open(path).map_err(Error::io("open", path))?;
                if other.length() < length {
                    return short(path, other.length());
                }
                other.seek(SeekFrom::Start(offset)).map_err(Error::io("read", path))?;
                Ok(Box::new(other))
            }
            Place::Within(text) => {
                let has = text.trim_end_matches('=').len() as u64 * 3 / 4;
                if has < length {
                    return short(&path, has);
                }
                // Four characters are three bytes.
                let rest = text.as_bytes().get(to_usize(offset / 3 * 4)..).unwrap_or_default();
                let mut bytes = DecoderReader::new(rest, &STANDARD);
                let before = (&mut bytes).take(offset % 3);
                io::copy(&mut { before }, &mut io::sink()).map_err(|why| Error::malformed(path, why.to_string()))?;
                Ok(Box::new(bytes))
            }
        }
    }
}

/// The relative path of a URI.
fn relative(uri: &str) -> Result<PathBuf, String> {
    let refused = || format!("its buffer is {}: a path below the folder of the file is needed", shown(uri));
    let path = PathBuf::from(decoded(uri).ok_or_else(refused)?);
    let inside = path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir));
    let plain = !uri.is_empty() && !uri.contains([':', '\\']);
    if inside && plain { Ok(path) } else { Err(refused()) }
}

/// A URI with its escapes undone: `%20` is a blank.
fn decoded(uri: &str) -> Option<String> {
    let (mut bytes, mut rest) = (Vec::new(), uri.as_bytes());
    while let Some((first, others)) = rest.split_first() {
        rest = others;
        if *first == b'%' {
            let (code, others) = others.split_at_checked(2)?;
            bytes.push(u8::from_str_radix(std::str::from_utf8(code).ok()?, 16).ok()?);
            rest = others;
        } else {
            bytes.push(*first);
        }
    }
    String::from_utf8(bytes).ok().filter(|text| !text.contains(char::is_control))
}
