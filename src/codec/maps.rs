//! Reflectance maps for people: `.npz` for numpy, `.png` to look at.
//!
//! - `.npz`: `map` [N, 60, 120, 3] f32, mean linear radiance, 0 where nothing was observed; `count` [N, 60, 120] u32,
//!   observations.
//! - `.png`: the front halves (rows 0..30) of the maps, one under the other, 8-bit sRGB, every bin 4 x 4 pixels, a dark
//!   blue where nothing was observed, a line of white between maps.

use std::io::{Seek, Write};
use std::path::Path;

use zip::result::ZipResult;
use zip::write::SimpleFileOptions;
use zip::{CompressionMethod, ZipWriter};

use super::images;
use super::tables::npy;
use crate::base::convert::to_u32;
use crate::base::{Error, Result};
use crate::disk::write_atomic;
use crate::scene::reflectance::{BINS, COLUMNS, ROWS, SparseMap};

/// The most maps in one file: 64 MB of a picture.
const MOST: usize = 4096;

/// What writes maps to a file.
pub(crate) type Writer = fn(&Path, &[SparseMap]) -> Result<()>;

/// The writer that a file's name asks for.
///
/// # Errors
/// A name that ends in neither `.npz` nor `.png`.
pub(crate) fn writer(out: &Path) -> Result<Writer> {
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
    write_atomic(out, |to| npz(to, maps).map_err(|why| Error::io("write", out)(why.into())))
}

fn npz(out: impl Write + Seek, maps: &[SparseMap]) -> ZipResult<()> {
    let mut zip = ZipWriter::new(out);
    let stored = SimpleFileOptions::default().compression_method(CompressionMethod::Stored);
    zip.start_file("map.npy", stored)?;
    zip.write_all(&npy::heading("<f4", &[maps.len(), ROWS, COLUMNS, 3])?)?;
    for map in maps {
        let mut radiance = vec![[[0; 4]; 3]; BINS];
        map.bins.iter().for_each(|(bin, sum)| radiance[usize::from(*bin)] = sum.mean().map(f32::to_le_bytes));
        zip.write_all(radiance.as_flattened().as_flattened())?;
    }
    zip.start_file("count.npy", stored)?;
    zip.write_all(&npy::heading("<u4", &[maps.len(), ROWS, COLUMNS])?)?;
    for map in maps {
        let mut count = vec![[0; 4]; BINS];
        map.bins.iter().for_each(|(bin, sum)| count[usize::from(*bin)] = sum.count.to_le_bytes());
        zip.write_all(count.as_flattened())?;
    }
    zip.finish().map(drop)
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
            let color = sum.mean().map(images::to_srgb8);
            for line in picture[row * width..].chunks_mut(width).take(CELL) {
                line[column..column + CELL].fill(color);
            }
        }
    }
    images::write_png(out, &pixels, to_u32(width), to_u32(step * maps.len()))
}

#[cfg(test)]
mod tests {
    use std::io;

    use super::*;
    use crate::scene::reflectance::BinSum;

    #[test]
    fn an_npz_holds_means_and_counts() {
        let map = SparseMap { bins: vec![(7, BinSum::one([0.25, 0.5, 1.0], false))] };
        let mut bytes = io::Cursor::new(Vec::new());
        npz(&mut bytes, &[SparseMap::default(), map]).unwrap();
        let bytes = bytes.into_inner();
        let entry = |name: &str, header: &str, values: usize| {
            let at = bytes.windows(name.len()).position(|w| w == name.as_bytes()).unwrap() + name.len();
            let said = String::from_utf8_lossy(&bytes[at..at + 128]).into_owned();
            assert!(said.contains(header), "{said}");
            let values = bytes[at + 128..at + 128 + 4 * values].as_chunks::<4>().0;
            let nonzero = values.iter().enumerate().filter(|(_, v)| **v != [0; 4]);
            nonzero.map(|(i, v)| (i, u32::from_le_bytes(*v))).collect::<Vec<_>>()
        };
        let radiance = entry("map.npy", "'<f4', 'fortran_order': False, 'shape': (2, 60, 120, 3, )", 2 * BINS * 3);
        let at = (BINS + 7) * 3;
        assert_eq!(
            radiance,
            [0.25f32, 0.5, 1.0].iter().enumerate().map(|(c, v)| (at + c, v.to_bits())).collect::<Vec<_>>()
        );
        assert_eq!(
            entry("count.npy", "'<u4', 'fortran_order': False, 'shape': (2, 60, 120, )", 2 * BINS),
            [(BINS + 7, 1)]
        );
    }

    /// Where `GONIO_PYTHON` names a Python that has numpy.
    #[test]
    fn numpy_reads_an_npz() {
        let Some(python) = std::env::var_os("GONIO_PYTHON").filter(|p| !p.is_empty()) else {
            return println!("skipped: GONIO_PYTHON names no Python with numpy");
        };
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("m.npz");
        let map = SparseMap { bins: vec![(121, BinSum::one([0.25, 0.5, 1.0], false))] };
        write_npz(&file, &[SparseMap::default(), map]).unwrap();
        let script = "import numpy, sys, zipfile\n\
            assert zipfile.ZipFile(sys.argv[1]).testzip() is None\n\
            f = numpy.load(sys.argv[1])\n\
            print(sorted(f.files), f['map'].shape, f['map'].dtype, f['map'][1, 1, 1], f['map'].sum(), f['count'].dtype, f['count'][1, 1, 1], f['count'].sum())";
        let ran = std::process::Command::new(python).args(["-c", script]).arg(&file).output().unwrap();
        let said = String::from_utf8_lossy(&ran.stdout).into_owned();
        let needed = "['count', 'map'] (2, 60, 120, 3) float32 [0.25 0.5  1.  ] 1.75 uint32 1 1\n";
        assert_eq!(said, needed, "{}", String::from_utf8_lossy(&ran.stderr));
    }
}
