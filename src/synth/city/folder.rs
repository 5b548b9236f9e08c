//! A city's folder: whether it holds the wanted city, another or an unfinished city, or the files of another program.
//!
//! While a city is being made its folder holds the mark `city.unfinished`: empty as long as photographs of an earlier city
//! may be there, then with the configuration of this city, so that its photographs can be kept. When all other files are
//! durable, `city.json` is written and the mark is removed. A folder that is not empty and has neither file belongs to
//! another program and is left alone.

use std::fs;
use std::io::ErrorKind;
use std::path::Path;

use serde_json::{Value, json};

use super::{CityConfig, World};
use crate::base::{Error, Result};
use crate::disk::names::TEMPORARY;
use crate::disk::{DirStore, Space, Store, space, write_atomic};

/// The file of a finished city, written last: the configuration, and the counts of triangles and frames.
pub(super) const FINISHED: &str = "city.json";
/// The mark of a city that is being made.
const MARK: &str = "city.unfinished";
/// The version of the files that a configuration gives.
const VERSION: u32 = 1;

/// The counts of a finished city.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(crate) struct Summary {
    /// Triangles of the mesh.
    pub triangles: u64,
    /// Photographs.
    pub frames: u64,
    /// Whether the city was there already, made from the same configuration.
    pub reused: bool,
}

/// The contents of a folder.
#[derive(Debug, PartialEq, Eq)]
pub(super) enum Found {
    /// Nothing, or files of a city that may make way.
    Free,
    /// The finished city of this configuration.
    Finished(Summary),
}

/// Looks into a folder, which need not exist.
///
/// # Errors
/// The folder holds files that are not a city's, or cannot be read.
pub(super) fn look(folder: &Path, config: &CityConfig) -> Result<Found> {
    let mut entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(why) if why.kind() == ErrorKind::NotFound => return Ok(Found::Free),
        Err(why) => return Err(Error::io("read the folder", folder)(why)),
    };
    let Some(first) = entries.next() else { return Ok(Found::Free) };
    let finished = folder.join(FINISHED);
    let text = match fs::read_to_string(&finished) {
        Ok(text) => text,
        Err(why) if why.kind() == ErrorKind::NotFound && folder.join(MARK).is_file() => return Ok(Found::Free),
        Err(why) if why.kind() == ErrorKind::NotFound => {
            let name = first.map_err(Error::io("read the folder", folder))?.file_name();
            return Err(Error::malformed(
                folder,
                format!(
                    "it holds {} and no {FINISHED}, so it is no city's folder and is left alone; name a new or empty folder",
                    name.display()
                ),
            ));
        }
        Err(why) => return Err(Error::io("read", &finished)(why)),
    };
    let value: Value = serde_json::from_str(&text).unwrap_or_default();
    if value["format"] != "gonio city" {
        let words = "it lacks {\"format\": \"gonio city\"}, so the folder is another program's and is left alone; name a \
                     new or empty folder";
        return Err(Error::malformed(&finished, words));
    }
    let summary = |triangles, frames| Summary { triangles, frames, reused: true };
    // NOTE: texts are compared, since a number may be read as other bits than it was written from.
    match (value["triangles"].as_u64(), value["frames"].as_u64()) {
        (Some(t), Some(f)) if text == written(config, summary(t, f)) => Ok(Found::Finished(summary(t, f))),
        _ => Ok(Found::Free),
    }
}

/// Whether the folder holds the finished city.
pub(crate) fn is_finished(folder: &Path, config: &CityConfig) -> bool {
    matches!(look(folder, config), Ok(Found::Finished(_)))
}

/// The disk space that making the city takes; `None` where the finished city is there. Files of a city in the folder make
/// way or are kept, so their space counts as free.
///
/// # Errors
/// The errors of [`look`].
pub(crate) fn space(folder: &Path, config: &CityConfig) -> Result<Option<Space>> {
    if look(folder, config)? != Found::Free {
        return Ok(None);
    }
    let there: u64 = ["", "images", "truth", "unfinished"].iter().map(|sub| size(&folder.join(sub))).sum();
    let pixels = u64::from(config.frames) * u64::from(config.width) * u64::from(config.height);
    // In the real world the town that is photographed has up to three times the triangles that are handed out.
    let times = if config.world == World::Real { 4 } else { 1 };
    let all = BYTES_PER_PIXEL * pixels + BYTES_PER_TRIANGLE * times * u64::from(config.triangles);
    Ok(Some(Space { folder: folder.to_path_buf(), needs: all.saturating_sub(there), free: space::free(folder) }))
}

/// Bytes of a photograph's pixel: measured 0.34 with two by two samples, 1.05 with one.
const BYTES_PER_PIXEL: u64 = 1;
/// Bytes of a triangle: 41 in the mesh, 28 of its material, and while photographs are taken 138 in the scene cache and 8 of
/// its share of the sky.
const BYTES_PER_TRIANGLE: u64 = 215;

/// Bytes of the files in a folder, as far as the folder can be read.
fn size(folder: &Path) -> u64 {
    let entries = fs::read_dir(folder).into_iter().flatten().flatten();
    entries.filter_map(|entry| entry.metadata().ok()).filter(|found| found.is_file()).map(|found| found.len()).sum()
}

/// Marks the folder's city as unfinished, and only then forgets the finished city that it held.
pub(super) fn begin(folder: &Path) -> Result<()> {
    fs::create_dir_all(folder).map_err(Error::io("create", folder))?;
    // IMPORTANT: the mark first: a folder with neither file is taken for another program's.
    write_atomic(folder.join(MARK), |_| Ok(()))?;
    remove(&folder.join(FINISHED))
}

/// Writes into the mark that from now on all photographs in the folder are of this configuration.
pub(super) fn own(folder: &Path, config: &CityConfig) -> Result<()> {
    let path = folder.join(MARK);
    let text = mark(config);
    write_atomic(&path, |out| out.write_all(text.as_bytes()).map_err(Error::io("write", &path)))
}

/// Whether the folder holds an unfinished city of this configuration, whose photographs can be kept.
pub(super) fn owned(folder: &Path, config: &CityConfig) -> bool {
    let begun = fs::read_to_string(folder.join(MARK)).is_ok_and(|text| text == mark(config));
    begun && !folder.join(FINISHED).exists()
}

/// The text of the mark.
fn mark(config: &CityConfig) -> String {
    format!("{:#}\n", json!({ "version": VERSION, "config": config }))
}

/// Declares the city finished: all its other files must be durable.
pub(super) fn finish(folder: &Path, config: &CityConfig, summary: Summary) -> Result<()> {
    let path = folder.join(FINISHED);
    let text = written(config, summary);
    write_atomic(&path, |out| out.write_all(text.as_bytes()).map_err(Error::io("write", &path)))?;
    remove(&folder.join(MARK))
}

/// Makes a folder of the city's, and those above it up to `folder`.
///
/// # Errors
/// One of them is a link: what is removed there would be somebody's.
pub(super) fn make_below(folder: &Path, below: &str) -> Result<()> {
    let mut path = folder.to_path_buf();
    for part in below.split('/') {
        path.push(part);
        match fs::create_dir(&path) {
            Err(why) if why.kind() != ErrorKind::AlreadyExists => return Err(Error::io("create", &path)(why)),
            _ => {}
        }
        if !fs::symlink_metadata(&path).map_err(Error::io("look at", &path))?.is_dir() {
            let words = "it is a link or a file, where a folder of the city's is needed: move it away";
            return Err(Error::malformed(&path, words));
        }
    }
    Ok(())
}

/// Removes the photographs of a folder that are not wanted: those of an earlier city, and files that an interrupted making
/// left under temporary names.
pub(super) fn sweep(folder: &Path, wanted: impl Fn(&str) -> bool) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::io("read the folder", folder))? {
        let name = entry.map_err(Error::io("read the folder", folder))?.file_name();
        if name.to_str().is_some_and(|name| is_photograph(name) && !wanted(name)) {
            remove(&folder.join(name))?;
        }
    }
    Ok(())
}

/// Whether a city's photograph has this name, or had while it was written.
fn is_photograph(name: &str) -> bool {
    let Some((number, rest)) = name.strip_prefix("frame_").and_then(|rest| rest.split_once('.')) else { return false };
    let digits = |text: &str| !text.is_empty() && text.bytes().all(|byte| byte.is_ascii_digit());
    let temporary = rest.strip_prefix("jpg.").and_then(|rest| rest.strip_suffix(TEMPORARY));
    let written = temporary.and_then(|rest| rest.split_once('-')).is_some_and(|(pid, n)| digits(pid) && digits(n));
    digits(number) && (rest == "jpg" || written)
}

/// Makes all files of a folder durable.
pub(super) fn sync(folder: &Path) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::io("read the folder", folder))? {
        let path = entry.map_err(Error::io("read the folder", folder))?.path();
        fs::File::open(&path).and_then(|f| f.sync_all()).map_err(Error::io("sync", &path))?;
    }
    Ok(())
}

/// Removes a folder of the store's, with the files that are its own.
pub(super) fn remove_unfinished(store: &DirStore, folder: &str, is_own: impl Fn(&str) -> bool) -> Result<()> {
    for name in store.list(folder)? {
        if name.strip_prefix(folder).and_then(|name| name.strip_prefix('/')).is_some_and(&is_own) {
            store.remove(&name)?;
        }
    }
    // What else is there is somebody's, and keeps the folder.
    fs::remove_dir(store.path(folder)).unwrap_or_default();
    Ok(())
}

/// Removes a file, if the file exists.
pub(super) fn remove(path: &Path) -> Result<()> {
    match fs::remove_file(path) {
        Err(why) if why.kind() != ErrorKind::NotFound => Err(Error::io("remove", path)(why)),
        _ => Ok(()),
    }
}

/// The text of the file of a finished city.
fn written(config: &CityConfig, summary: Summary) -> String {
    let finished = json!({
        "format": "gonio city",
        "version": VERSION,
        "config": config,
        "triangles": summary.triangles,
        "frames": summary.frames,
    });
    format!("{finished:#}\n")
}
