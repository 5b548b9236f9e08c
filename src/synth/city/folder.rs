//! A city's folder: whether it holds what is wanted, something of an earlier or interrupted making, or something else.
//!
//! While a city is being made its folder holds `city.unfinished`: empty as long as there may be photographs of an earlier
//! city, then with the configuration of this one, so that the photographs that are there can be kept. When all other files
//! are durable `city.json` is written and the mark is taken away. A folder with neither, that is not empty, is not ours and
//! is left alone.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use serde_json::{Value, json};

use super::CityConfig;
use crate::base::{Error, Result};
use crate::disk::{Room, room, write_atomic};

/// Written last: the configuration, and what came of it.
pub const RECORD: &str = "city.json";
/// There while the city is being made.
const MARK: &str = "city.unfinished";
/// Changes whenever the same configuration gives other files.
const VERSION: u32 = 1;

/// What a finished city amounts to.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Summary {
    /// Triangles of the mesh.
    pub triangles: u64,
    /// Photographs.
    pub frames: u64,
    /// Whether it was there already, made from the same configuration.
    pub reused: bool,
}

/// What the folder holds.
#[derive(Debug, PartialEq, Eq)]
pub enum Found {
    /// Nothing that is wanted, and nothing of anybody else's.
    Room,
    /// A finished city of this configuration.
    Finished(Summary),
}

/// Looks what a folder holds; it need not be there.
///
/// # Errors
/// The folder holds something that is not a city, or cannot be read.
pub fn look(folder: &Path, config: &CityConfig) -> Result<Found> {
    let mut entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(why) if why.kind() == ErrorKind::NotFound => return Ok(Found::Room),
        Err(why) => return Err(Error::io("read the folder", folder)(why)),
    };
    let Some(first) = entries.next() else { return Ok(Found::Room) };
    let record = folder.join(RECORD);
    let text = match fs::read_to_string(&record) {
        Ok(text) => text,
        Err(why) if why.kind() == ErrorKind::NotFound && folder.join(MARK).is_file() => return Ok(Found::Room),
        Err(why) if why.kind() == ErrorKind::NotFound => {
            let name = first.map_err(Error::io("read the folder", folder))?.file_name();
            return Err(Error::malformed(
                folder,
                format!(
                    "holds {} and no {RECORD}: this is no city, and is left alone; name a new or empty folder",
                    name.display()
                ),
            ));
        }
        Err(why) => return Err(Error::io("read", &record)(why)),
    };
    let value: Value = serde_json::from_str(&text).unwrap_or_default();
    if value["format"] != "gonio city" {
        let words = "does not say {\"format\": \"gonio city\"}: the folder is another program's, and is left alone";
        return Err(Error::malformed(&record, words));
    }
    let summary = |triangles, frames| Summary { triangles, frames, reused: true };
    // As text: a number need not be read as the bits that it was written from.
    match (value["triangles"].as_u64(), value["frames"].as_u64()) {
        (Some(t), Some(f)) if text == written(config, summary(t, f)) => Ok(Found::Finished(summary(t, f))),
        _ => Ok(Found::Room),
    }
}

/// Whether the folder holds the finished city.
pub fn is_finished(folder: &Path, config: &CityConfig) -> bool {
    matches!(look(folder, config), Ok(Found::Finished(_)))
}

/// The room that making the city takes, none where it is there. What is in the folder makes way, or is kept.
///
/// # Errors
/// As for [`look`].
pub fn room(folder: &Path, config: &CityConfig) -> Result<Option<Room>> {
    if look(folder, config)? != Found::Room {
        return Ok(None);
    }
    let there: u64 = ["", "images", "truth", "unfinished"].iter().map(|sub| size(&folder.join(sub))).sum();
    let pixels = u64::from(config.frames) * u64::from(config.width) * u64::from(config.height);
    let all = BYTES_PER_PIXEL * pixels + BYTES_PER_TRIANGLE * u64::from(config.triangles);
    Ok(Some(Room { folder: folder.to_path_buf(), needs: all.saturating_sub(there), free: room::free(folder) }))
}

/// Bytes of a photograph's pixel: 0.34 were measured with two by two samples, 1.05 with one.
const BYTES_PER_PIXEL: u64 = 1;
/// Bytes of a triangle: 41 in the mesh, 28 of its material, and while photographs are taken 138 of the scene cache and 8 of
/// the sky.
const BYTES_PER_TRIANGLE: u64 = 215;

/// Bytes of the files in a folder, as far as it can be read.
fn size(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).filter(|found| found.is_file()).map(|found| found.len()).sum()
}

/// Marks the folder as being made, and only then forgets the city that it held.
pub fn begin(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::io("create", folder))?;
    // IMPORTANT: the mark first: a folder with neither is taken for somebody else's.
    write_atomic(folder.join(MARK), |_| Ok(()))?;
    remove(&folder.join(RECORD))
}

/// Says that from now on all photographs in the folder are of this configuration.
pub fn own(folder: &Path, config: &CityConfig) -> Result<()> {
    let path = folder.join(MARK);
    let text = mark(config);
    write_atomic(&path, |out| out.write_all(text.as_bytes()).map_err(Error::io("write", &path)))
}

/// Whether a city of this configuration was being made here, so that its photographs can be kept.
pub fn owned(folder: &Path, config: &CityConfig) -> bool {
    let begun = fs::read_to_string(folder.join(MARK)).is_ok_and(|text| text == mark(config));
    begun && !folder.join(RECORD).exists()
}

fn mark(config: &CityConfig) -> String {
    format!("{:#}\n", json!({ "version": VERSION, "config": config }))
}

/// Declares the city finished: everything else must be durable.
pub fn finish(folder: &Path, config: &CityConfig, summary: Summary) -> Result<()> {
    let path = folder.join(RECORD);
    let text = written(config, summary);
    write_atomic(&path, |out| out.write_all(text.as_bytes()).map_err(Error::io("write", &path)))?;
    remove(&folder.join(MARK))
}

/// Removes the files of a folder that begin with `stem` but are not wanted: frames of an earlier city, and what an
/// interrupted one left under temporary names.
pub fn sweep(folder: &Path, stem: &str, wanted: impl Fn(&str) -> bool) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::io("read the folder", folder))? {
        let name = entry.map_err(Error::io("read the folder", folder))?.file_name();
        if name.to_str().is_some_and(|name| name.starts_with(stem) && !wanted(name)) {
            remove(&folder.join(name))?;
        }
    }
    Ok(())
}

/// Makes all files of a folder durable.
pub fn sync(folder: &Path) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::io("read the folder", folder))? {
        let path = entry.map_err(Error::io("read the folder", folder))?.path();
        fs::File::open(&path).and_then(|f| f.sync_all()).map_err(Error::io("sync", &path))?;
    }
    Ok(())
}

/// Removes a folder with all that is in it, if it is there.
pub fn remove_all(path: &Path) -> Result<()> {
    match fs::remove_dir_all(path) {
        Err(why) if why.kind() != ErrorKind::NotFound => Err(Error::io("remove", path)(why)),
        _ => Ok(()),
    }
}

/// Removes a file, if it is there.
pub fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(why) if why.kind() != ErrorKind::NotFound => Err(Error::io("remove", path)(why)),
        _ => Ok(()),
    }
}

fn written(config: &CityConfig, summary: Summary) -> String {
    let record = json!({
        "format": "gonio city",
        "version": VERSION,
        "config": config,
        "triangles": summary.triangles,
        "frames": summary.frames,
    });
    format!("{record:#}\n")
}
