//! The format `realitycapture`: a `.csv` file, or a folder of `.xmp` files.

use std::path::{Path, PathBuf};

use super::{csv, xmp};
use crate::base::{Error, Result};
use crate::codec::poses::format::{PoseFormat, Posed, Target};
use crate::codec::poses::photographs::Photographs;
use crate::codec::poses::{found, whole};

/// RealityCapture's registration.
pub(crate) const REALITYCAPTURE: PoseFormat = PoseFormat {
    name: "realitycapture",
    programs: "RealityCapture, RealityScan",
    target: Target::Either,
    advice: "name the .csv of the registration, or the folder that holds an .xmp for each image",
    is_at: |path| table(path).is_some() || sidecars(path).iter().take(LOOKED_INTO).any(|file| xmp::is_one(file)),
    missing: |path| {
        let there = !found::ending(path, &[".csv", ".xmp"]).is_empty() || table(path).is_some();
        found::missing(path, there, "must be a .csv of a registration, or hold .xmp files")
    },
    read,
};

/// The most sidecars that are looked into for one of RealityCapture's.
const LOOKED_INTO: usize = 64;

/// The table at a path.
fn table(path: &Path) -> Option<PathBuf> {
    let all = if path.is_file() { vec![path.to_owned()] } else { found::ending(path, &[".csv"]) };
    all.into_iter().find(|file| csv::is_one(&whole::start_text(file, 4096)))
}

fn sidecars(path: &Path) -> Vec<PathBuf> {
    found::ending(path, &[".xmp"])
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    if let Some(table) = table(path) {
        return csv::read(&table, photographs);
    }
    let sidecars = sidecars(path);
    if let (Some(other), true) = (found::ending(path, &[".csv"]).first(), sidecars.is_empty()) {
        return csv::read(other, photographs);
    }
    if sidecars.is_empty() {
        let found = "neither a .csv whose first line names name, x, y, alt, heading, pitch, roll and f, nor .xmp files";
        return Err(Error::malformed(path, found));
    }
    xmp::read(&sidecars, photographs)
}
