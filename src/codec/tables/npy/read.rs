//! Reads arrays.

use std::io::{BufReader, Read};
use std::path::Path;

use super::header::{self, Fault, Header};
use crate::base::array::SharedBytes;
use crate::base::convert::{to_f32, to_usize};
use crate::base::input::Input;
use crate::base::shown::short;
use crate::base::{Array, Error, Result};

/// Values that are converted at a time.
const CHUNK: usize = 1 << 14;

/// Reads a whole array: its shape, and its values row by row.
///
/// # Errors
/// A file that cannot be read, or that is no array of `<f4` or `<f8` to its last byte.
pub(crate) fn read_f32(path: &Path) -> Result<(Vec<usize>, Vec<f32>)> {
    let file = Input::open(path).map_err(Error::io("open", path))?;
    let length = file.length();
    parse(BufReader::new(file), length).map_err(|fault| fault.of(path))
}

/// Reads an array of the shape `[n, columns]`: `n` rows, one after the other.
///
/// # Errors
/// Those of `read_f32`; any other shape.
pub fn read_rows<const COLUMNS: usize>(path: &Path) -> Result<Vec<[f32; COLUMNS]>> {
    rows(read_f32(path)?, path)
}

/// Reads an array of the shape `[n, columns]` from shared bytes, as those of a mapped file. Rows of f32 stay where they
/// are: only the header is looked at. Errors name `path`.
///
/// # Errors
/// Those of [`read_rows`].
pub fn view<const COLUMNS: usize>(bytes: SharedBytes, path: &Path) -> Result<Array<[f32; COLUMNS]>> {
    let all = (*bytes).as_ref();
    let header = header::read(&mut &all[..], all.len() as u64).map_err(|fault| fault.of(path))?;
    if header.wide || cfg!(target_endian = "big") {
        let found = parse(all, all.len() as u64).map_err(|fault| fault.of(path))?;
        return Ok(rows(found, path)?.into());
    }
    check_columns::<COLUMNS>(&header.shape, path)?;
    Array::view(&bytes, to_usize(header.start)..all.len()).map_err(|found| Error::malformed(path, found))
}

fn check_columns<const COLUMNS: usize>(shape: &[usize], path: &Path) -> Result<()> {
    if matches!(shape, [_, columns] if *columns == COLUMNS) {
        return Ok(());
    }
    Err(Error::malformed(
        path,
        format!("its shape is {}, where [n, {COLUMNS}] is needed", short(&format!("{shape:?}"))),
    ))
}

fn rows<const COLUMNS: usize>((shape, values): (Vec<usize>, Vec<f32>), path: &Path) -> Result<Vec<[f32; COLUMNS]>> {
    check_columns::<COLUMNS>(&shape, path)?;
    // In place as a rule: a table may be a large part of the memory.
    Ok(bytemuck::allocation::try_cast_vec(values).unwrap_or_else(|(_, values)| values.as_chunks().0.to_vec()))
}

/// The shape and the values of a file of `length` bytes.
pub(super) fn parse(mut file: impl Read, length: u64) -> Result<(Vec<usize>, Vec<f32>), Fault> {
    let Header { shape, wide, start } = header::read(&mut file, length)?;
    let (width, bytes) = (if wide { 8 } else { 4 }, length - start);
    let mut raw = Vec::new();
    let mut out = Vec::with_capacity(to_usize(bytes / width));
    loop {
        raw.clear();
        if file.by_ref().take(CHUNK as u64 * width).read_to_end(&mut raw)? == 0 {
            break;
        }
        if wide {
            out.extend(raw.as_chunks().0.iter().map(|v| to_f32(f64::from_le_bytes(*v))));
        } else {
            out.extend(raw.as_chunks().0.iter().map(|v| f32::from_le_bytes(*v)));
        }
    }
    if out.len() as u64 * width != bytes {
        let read = out.len() as u64 * width;
        return Err(Fault::Found(format!(
            "it had {bytes} bytes of values when it was opened, and {read} when it was read"
        )));
    }
    Ok((shape, out))
}
