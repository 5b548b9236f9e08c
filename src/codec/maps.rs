//! Reflectance maps for people: `.npz` for numpy, `.png` to look at.
//!
//! - `.npz`: `map` [N, 60, 120, 3] f32, mean linear radiance, 0 where nothing was observed; `count` [N, 60, 120] u32,
//!   observations.
//! - `.png`: the front halves (rows 0..30) of the maps, one under the other, 8-bit sRGB, every bin 4 x 4 pixels, a dark
//!   blue where nothing was observed, a line of white between maps.

use std::fs::File;
use std::path::Path;

use ndarray::{Array3, Array4};
use ndarray_npy::NpzWriter;

use super::image;
use crate::base::{Error, Result};
use crate::scene::reflectance::{COLUMNS, ROWS, SparseMap};

/// The most maps in one file: 64 MB of a picture.
const MOST: usize = 4096;

/// What writes maps to a file.
pub type Writer = fn(&Path, &[SparseMap]) -> Result<()>;

/// The writer that a file's name asks for.
///
/// # Errors
/// A name that ends in neither `.npz` nor `.png`.
pub fn writer(out: &Path) -> Result<Writer> {
    match out.extension().and_then(|e| e.to_str()) {
        Some("npz") => Ok(write_npz),
        Some("png") => Ok(write_png),
        _ => Err(Error::invalid(format!("{}: maps are written as .npz or .png: name the file so", out.display()))),
    }
}

fn bounded(maps: &[SparseMap]) -> Result<()> {
    if maps.len() > MOST {
        return Err(Error::invalid(format!("{} maps are too many for one file: at most {MOST}", maps.len())));
    }
    Ok(())
}

fn write_npz(out: &Path, maps: &[SparseMap]) -> Result<()> {
    bounded(maps)?;
    let mut radiance = Array4::<f32>::zeros((maps.len(), ROWS, COLUMNS, 3));
    let mut count = Array3::<u32>::zeros((maps.len(), ROWS, COLUMNS));
    for (n, map) in maps.iter().enumerate() {
        for (bin, sum) in &map.bins {
            let (row, column) = (usize::from(*bin) / COLUMNS, usize::from(*bin) % COLUMNS);
            for (c, value) in sum.mean().into_iter().enumerate() {
                radiance[[n, row, column, c]] = value;
            }
            count[[n, row, column]] = sum.count;
        }
    }
    let mut npz = NpzWriter::new(File::create(out).map_err(Error::io("create", out))?);
    let written = npz.add_array("map", &radiance).and_then(|()| npz.add_array("count", &count));
    let finished = written.and_then(|()| npz.finish());
    finished.map(drop).map_err(|why| Error::io("write", out)(std::io::Error::other(why)))
}

/// Pixels along a bin.
const CELL: usize = 4;
/// Rows of a map that a picture shows.
const SHOWN: usize = ROWS / 2;

fn write_png(out: &Path, maps: &[SparseMap]) -> Result<()> {
    bounded(maps)?;
    let (width, step) = (COLUMNS * CELL, SHOWN * CELL + 1);
    let mut pixels = vec![[255u8; 3]; width * step * maps.len()];
    for (map, picture) in maps.iter().zip(pixels.chunks_exact_mut(width * step)) {
        picture[..width * SHOWN * CELL].fill([16, 16, 48]);
        for (bin, sum) in &map.bins {
            let (row, column) = (usize::from(*bin) / COLUMNS * CELL, usize::from(*bin) % COLUMNS * CELL);
            let color = sum.mean().map(image::to_srgb8);
            for line in picture[row * width..].chunks_mut(width).take(CELL) {
                line[column..column + CELL].fill(color);
            }
        }
    }
    image::write_png(out, &pixels, width as u32, (step * maps.len()) as u32)
}
