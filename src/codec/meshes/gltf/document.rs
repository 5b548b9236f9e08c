//! The JSON of a glTF, and the binary chunk that may follow it in the same file.
//!
//! ```text
//! .glb     b"glTF", u32 version 2, u32 length; u32 length b"JSON" text; u32 length b"BIN\0" bytes: little endian
//! .gltf    the JSON alone
//! ```

use std::io::{ErrorKind, Read, Seek, SeekFrom};
use std::path::Path;

use ::gltf::Document;

use crate::base::guard::guarded;
use crate::base::input::Input;
use crate::base::shown::{brief, shown};
use crate::base::{Error, Result};

/// The most bytes of JSON: some million nodes.
const LARGEST_JSON: u64 = 256 << 20;

/// The extensions that keep positions in another form.
const OTHER_FORMS: [&str; 4] =
    ["KHR_draco_mesh_compression", "EXT_meshopt_compression", "KHR_meshopt_compression", "KHR_mesh_quantization"];

/// The extensions that put positions elsewhere, or put them there many times.
const OTHER_PLACES: [&str; 2] = ["CESIUM_RTC", "EXT_mesh_gpu_instancing"];

/// The binary chunk of a file.
#[derive(Debug, Clone, Copy)]
pub(super) struct Chunk {
    /// The position of the chunk's first byte in the file.
    pub start: u64,
    /// How many bytes it has.
    pub length: u64,
}

/// Reads the document of a file, whose indices all lead somewhere, and finds the binary chunk.
///
/// # Errors
/// A file that is no glTF 2.0, or that was cut short; positions in a form that is not read.
pub(super) fn read(file: &mut Input) -> Result<(Document, Option<Chunk>)> {
    let path = file.path().to_owned();
    let (json, chunk) = parts(file, &path)?;
    Ok((document(&json).map_err(|why| Error::malformed(&path, why))?, chunk))
}

/// The JSON of a file, and where its binary chunk lies.
fn parts(file: &mut Input, path: &Path) -> Result<(Vec<u8>, Option<Chunk>)> {
    let length = file.length();
    let fault = |why: &str| Error::malformed(path, why);
    let failed = |why| Error::io("read", path)(why);
    let mut head = Vec::new();
    Read::take(&mut *file, 20).read_to_end(&mut head).map_err(failed)?;
    let text = head.strip_prefix(b"\xef\xbb\xbf").unwrap_or(&head);
    if text.trim_ascii_start().starts_with(b"{") {
        return alone(file, path, text.to_vec()).map(|json| (json, None));
    }
    if !head.starts_with(b"glTF") {
        return Err(fault("this is no glTF: it begins neither with glTF, as a .glb does, nor with { as a .gltf"));
    }
    if head.len() < 20 {
        return Err(fault("the file ends within its head"));
    }
    let number = |at: usize| head[at..at + 4].iter().rev().fold(0u32, |all, byte| all << 8 | u32::from(*byte));
    if (number(4), number(16)) != (2, u32::from_le_bytes(*b"JSON")) {
        return Err(fault("it is no GLB of version 2 that begins with JSON"));
    }
    let bytes = u64::from(number(12));
    if bytes > LARGEST_JSON || bytes + 20 > length {
        return Err(fault(&format!("its JSON is said to have {bytes} bytes, and the file has {length}")));
    }
    let mut json = Vec::new();
    Read::take(&mut *file, bytes).read_to_end(&mut json).map_err(failed)?;
    let start = 20 + bytes;
    let mut head = [0; 8];
    if start + 8 > length {
        return Ok((json, None));
    }
    file.seek(SeekFrom::Start(start)).map_err(failed)?;
    file.read_exact(&mut head).map_err(|why| match why.kind() {
        ErrorKind::UnexpectedEof => fault("the file ends within its head"),
        _ => Error::io("read", path)(why),
    })?;
    let chunk = u64::from(u32::from_le_bytes([head[0], head[1], head[2], head[3]]));
    if &head[4..] != b"BIN\0" {
        return Ok((json, None));
    }
    if start + 8 + chunk > length {
        return Err(fault(&format!("its binary chunk is said to have {chunk} bytes; the file was cut short")));
    }
    Ok((json, Some(Chunk { start: start + 8, length: chunk })))
}

/// The JSON that is all of a file, whose first bytes were read.
fn alone(file: &mut Input, path: &Path, mut json: Vec<u8>) -> Result<Vec<u8>> {
    if file.length() > LARGEST_JSON {
        let found = format!("it has {} bytes; at most {LARGEST_JSON} are read as JSON: save it as .glb", file.length());
        return Err(Error::malformed(path, found));
    }
    Read::take(&mut *file, LARGEST_JSON).read_to_end(&mut json).map_err(Error::io("read", path))?;
    Ok(json)
}

fn document(json: &[u8]) -> Result<Document, String> {
    // Some writers fill up the JSON with zeros instead of blanks.
    let end = json.iter().rposition(|byte| *byte != 0).map_or(0, |at| at + 1);
    let json = &json[..end];
    let mut root = ::gltf::json::deserialize::from_slice::<::gltf::json::Root>(json).map_err(|why| brief(&why))?;
    if let Some(other) = root.extensions_used.iter().find(|name| OTHER_PLACES.contains(&name.as_str())) {
        return Err(format!("its positions are moved by {}, which is not read: export without it", shown(other)));
    }
    let compressed =
        |name: &str| format!("its positions are compressed by {}, which is not read: export without it", shown(name));
    let other = |names: &[String]| names.iter().find(|name| OTHER_FORMS.contains(&name.as_str())).cloned();
    if let Some(other) = other(&root.extensions_required) {
        return Err(compressed(&other));
    }
    let optional = other(&root.extensions_used);
    // What else a viewer must have does not move a vertex.
    root.extensions_required.clear();
    // The check of indices panics where a list is shorter than an index into it.
    let checked = guarded(|| Document::from_json(root));
    let checked = checked.map_err(|why| format!("its JSON leads nowhere: {why}"))?;
    // What is compressed without being said to be needed has nothing else to be read.
    checked.map_err(|why| optional.map_or_else(|| brief(&why), |other| compressed(&other)))
}
