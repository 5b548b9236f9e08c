//! The format `colmap`: a folder with the files of a sparse model.

use std::path::Path;

use super::{binary, text};
use crate::base::{Error, Result};
use crate::codec::poses::format::{Missing, PoseFormat, Target};
use crate::scene::frame::Frame;

/// The folder of a COLMAP sparse model, binary or text.
pub const COLMAP: PoseFormat = PoseFormat {
    name: "colmap",
    programs: "COLMAP, GLOMAP",
    target: Target::Folder,
    advice: "name the folder that holds cameras.bin and images.bin, or both as .txt",
    is_at: |folder| has(folder, "bin") || has(folder, "txt"),
    missing,
    read,
};

/// Where below a folder a model usually lies.
const USUAL: [&str; 3] = ["0", "sparse/0", "sparse"];

fn missing(folder: &Path) -> Option<Missing> {
    let holds = |folder: &Path| has(folder, "bin") || has(folder, "txt");
    if !folder.is_dir() || holds(folder) {
        return None;
    }
    let instead = USUAL.iter().map(|below| folder.join(below)).find(|below| holds(below));
    Some(Missing { rule: "must hold cameras.bin and images.bin, or both as .txt", instead })
}

fn read(folder: &Path) -> Result<Vec<Frame>> {
    let file = |name: &str, ending: &str| folder.join(name).with_extension(ending);
    if has(folder, "bin") {
        binary::images(&file("images", "bin"), &binary::cameras(&file("cameras", "bin"))?)
    } else if has(folder, "txt") {
        text::images(&file("images", "txt"), &text::cameras(&file("cameras", "txt"))?)
    } else {
        let found = "no COLMAP model: cameras.bin and images.bin, or cameras.txt and images.txt, are needed";
        Err(Error::malformed(folder, found))
    }
}

/// Whether a folder holds both files of a model with this ending.
fn has(folder: &Path, ending: &str) -> bool {
    ["cameras", "images"].iter().all(|name| folder.join(name).with_extension(ending).is_file())
}
