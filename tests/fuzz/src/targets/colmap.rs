//! Any two files under the names of a COLMAP model, binary (an even first byte) or text. The next two bytes say where they
//! part.

use std::fs;

use gonio::internals::codec::poses;

use super::poses::hold_sound;
use super::{BUFFERS, Target};
use crate::input;

/// A camera takes 24 bytes or more of a file, and becomes a lens that knows its reach; an image's name may come in an error.
pub const COLMAP: Target = Target { name: "colmap", read, may_hold: |bytes| BUFFERS + 32 * bytes };

fn read(bytes: &[u8]) -> bool {
    let Some((kind, rest)) = input::kind(bytes, 2) else { return false };
    let Some((length, rest)) = rest.split_first_chunk() else { return false };
    let (cameras, images) = rest.split_at(rest.len().min(u16::from_le_bytes(*length).into()));
    let (ending, other) = if kind == 0 { ("bin", "txt") } else { ("txt", "bin") };
    let folder = input::folder().join("model");
    fs::create_dir_all(&folder).unwrap();
    for (name, bytes) in [("cameras", cameras), ("images", images)] {
        fs::remove_file(folder.join(name).with_extension(other)).unwrap_or_default();
        fs::write(folder.join(name).with_extension(ending), bytes).unwrap();
    }
    let frames = match poses::read(&poses::COLMAP, &folder, &poses::NoPhotographs) {
        Ok(frames) => frames,
        Err(why) => {
            assert!(why.to_string().len() < 4096, "an error of {} bytes", why.to_string().len());
            return false;
        }
    };
    hold_sound(&frames);
    true
}
