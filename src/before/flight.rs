//! When and where the photographs were taken, and whether all were exposed alike, as their EXIF tells.

use std::path::Path;

use super::photographs::Photographs;
use crate::base::shown::short;
use crate::codec::images::{Exposure, Taken, taken};
use crate::phases::{middle_place, middle_time};

/// The most photographs that are looked at, evenly over the flight.
const LOOKED: usize = 64;

/// What the photographs tell, a name and words each.
pub(super) fn lines(root: &Path, photographs: &Photographs) -> Vec<(&'static str, String)> {
    let files: Vec<&String> = photographs.files.iter().flatten().collect();
    let folder = root.join(&photographs.folder);
    // What cannot be read tells nothing.
    let read = |file: &&String| taken(&folder.join(file)).unwrap_or_default();
    let told: Vec<Taken> = files.iter().step_by(files.len().div_ceil(LOOKED).max(1)).map(read).collect();
    let mut flight = Vec::new();
    if let Some((time, [from, to])) = middle_time(&told) {
        let minutes = (to - from) / 60;
        let zone = if time.zone.is_some() { "" } else { ", by a clock of unknown zone" };
        flight.push(format!("{time}{zone}, {minutes} minutes long"));
    }
    if let Some([latitude, longitude]) = middle_place(&told) {
        flight.push(format!("latitude {latitude:.5}, longitude {longitude:.5}"));
    }
    let flight =
        if flight.is_empty() { "no photograph tells when or where it was taken".into() } else { flight.join("; ") };
    vec![("flight", flight), ("exposure", exposed(&told.iter().map(|taken| taken.exposure).collect::<Vec<_>>()))]
}

/// Whether all photographs that tell it were exposed alike.
fn exposed(all: &[Exposure]) -> String {
    let told: Vec<&Exposure> = all.iter().filter(|exposure| exposure.is_told()).collect();
    let Some(first) = told.first() else { return "no photograph tells how it was exposed".to_owned() };
    if told.len() < all.len() {
        return format!("{} of {} photographs tell how they were exposed", told.len(), all.len());
    }
    let mut different: Vec<String> = told.iter().map(|exposure| exposure.to_string()).collect();
    different.sort();
    different.dedup();
    match different.len() {
        1 => format!("locked: {}, in all of {} that were looked at", short(&first.to_string()), all.len()),
        many => format!(
            "not locked: {many} settings in {} that were looked at, which [decode] exposure = \"solve\" evens out",
            all.len()
        ),
    }
}
