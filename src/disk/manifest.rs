//! The manifest: which units of work are done, and which files they left. `manifest.json`, one object:
//!
//! ```text
//! version    1
//! checksum   BLAKE3 in hex of `units` as compact JSON with sorted keys
//! units      by unit key: a list of { name, bytes, checksum }
//! ```
//!
//! It is replaced as a whole and last of all: a unit is done when the manifest that names it is on the disk. A file
//! belongs to one unit. A unit is committed once.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::store::{Content, FileEntry, Store, check_name};
use crate::base::key::Key;
use crate::base::{Error, Result};

/// The manifest's name in the store.
pub const MANIFEST: &str = "manifest.json";

/// The version of the layout above.
pub const VERSION: u32 = 1;

/// Files by unit key.
pub type Units = BTreeMap<String, Vec<FileEntry>>;

/// The manifest of an open run.
#[derive(Debug)]
pub struct Manifest {
    store: Arc<dyn Store>,
    units: Units,
}

/// What was found when a run was opened; all empty where the last run ended well.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Opening {
    /// A manifest that could not be read: where it was put, and what was wrong with it. All its units are lost.
    pub set_aside: Option<(String, String)>,
    /// Units whose files are gone or have another size, and what was found. They are to be done again.
    pub lost: Vec<(String, String)>,
    /// Files of broken runs that were removed.
    pub swept: Vec<String>,
}

#[derive(Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
struct Layout {
    version: u32,
    checksum: String,
    units: Units,
}

/// The one field that all versions share.
#[derive(Deserialize)]
struct AnyLayout {
    version: u32,
}

impl Manifest {
    /// Opens the run in a store for writing; the caller holds its lock. `owned` are the names of the files that a run
    /// may leave, and its folders, which end in `/`: of these, what the manifest does not name is removed.
    ///
    /// # Errors
    /// The manifest is of another version; the store fails.
    pub fn open(store: Arc<dyn Store>, owned: &[&str]) -> Result<(Manifest, Opening)> {
        let mut opening = Opening::default();
        let mut units = Units::new();
        if store.size(MANIFEST)?.is_some() {
            let content = store.open(MANIFEST)?;
            match parse(&*store, &content)? {
                Ok(found) => units = found,
                Err(fault) => opening.set_aside = Some((set_aside(&*store, &content)?, fault)),
            }
        }
        for (unit, files) in &units {
            if let Some(fault) = missing(&*store, files)? {
                opening.lost.push((unit.clone(), fault));
            }
        }
        opening.lost.iter().for_each(|(unit, _)| {
            units.remove(unit);
        });
        let manifest = Manifest { store, units };
        // IMPORTANT: the manifest stops naming a file before the file is removed.
        if opening.set_aside.is_some() || !opening.lost.is_empty() {
            manifest.write()?;
        }
        opening.swept = manifest.sweep(owned)?;
        Ok((manifest, opening))
    }

    /// Reads the manifest of a run that may be under way, and changes nothing. Without one, no unit is done.
    ///
    /// # Errors
    /// The manifest is corrupt or of another version; the store fails.
    pub fn read(store: Arc<dyn Store>) -> Result<Manifest> {
        let mut units = Units::new();
        if store.size(MANIFEST)?.is_some() {
            let parsed = parse(&*store, &store.open(MANIFEST)?)?;
            units = parsed.map_err(|fault| Error::malformed(store.path(MANIFEST), fault))?;
        }
        Ok(Manifest { store, units })
    }

    /// All units that are done, with their files, sorted by key.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// The files of a unit, if it is done.
    pub fn files(&self, unit: &str) -> Option<&[FileEntry]> {
        self.units.get(unit).map(Vec::as_slice)
    }

    /// Makes units done; their files are committed already.
    ///
    /// # Errors
    /// A unit that is done already, a file that is not in the store as it is said to be or belongs to another unit; the
    /// store fails. Then nothing has changed.
    pub fn commit(&mut self, units: impl IntoIterator<Item = (String, Vec<FileEntry>)>) -> Result<()> {
        let mut all = self.units.clone();
        for (unit, files) in units {
            if let Some(fault) = missing(&*self.store, &files)? {
                return Err(Error::invalid(format!("unit {unit} cannot be committed: {fault}")));
            }
            if all.insert(unit.clone(), files).is_some() {
                return Err(Error::invalid(format!("unit {unit} is committed already")));
            }
        }
        if let Some(fault) = fault_of(&all) {
            return Err(Error::invalid(format!("cannot commit: {fault}")));
        }
        self.adopt(all)
    }

    /// Forgets units, if they are done, and removes their files.
    pub fn forget<'a>(&mut self, units: impl IntoIterator<Item = &'a str>) -> Result<()> {
        let mut all = self.units.clone();
        let forgotten: Vec<FileEntry> = units.into_iter().filter_map(|unit| all.remove(unit)).flatten().collect();
        // IMPORTANT: the manifest stops naming a file before the file is removed.
        self.adopt(all)?;
        forgotten.iter().try_for_each(|file| self.store.remove(&file.name))
    }

    /// Makes these the units that are done, on the disk and then here.
    fn adopt(&mut self, units: Units) -> Result<()> {
        let before = std::mem::replace(&mut self.units, units);
        self.write().inspect_err(|_| self.units = before)
    }

    fn write(&self) -> Result<()> {
        let layout = Layout { version: VERSION, checksum: checksum(&self.units), units: self.units.clone() };
        let mut draft = self.store.create(MANIFEST)?;
        serde_json::to_writer_pretty(&mut draft, &layout)
            .map_err(std::io::Error::from)
            .and_then(|()| draft.write_all(b"\n"))
            .map_err(Error::io("write", self.store.path(MANIFEST)))?;
        draft.replace().map(drop)
    }

    fn sweep(&self, owned: &[&str]) -> Result<Vec<String>> {
        let named: BTreeSet<&str> = self.units.values().flatten().map(|file| file.name.as_str()).collect();
        let mut swept = self.store.sweep()?;
        for place in owned {
            let present = match place.strip_suffix('/') {
                Some(folder) => self.store.list(folder)?,
                None if self.store.size(place)?.is_some() => vec![(*place).to_owned()],
                None => Vec::new(),
            };
            for name in present.into_iter().filter(|name| !named.contains(name.as_str())) {
                self.store.remove(&name)?;
                swept.push(name);
            }
        }
        Ok(swept)
    }
}

fn checksum(units: &Units) -> String {
    // Strings and numbers in a map with string keys have no way to fail.
    Key(*blake3::hash(&serde_json::to_vec(units).unwrap_or_default()).as_bytes()).to_string()
}

/// The units, or what is wrong with the manifest. Another version is an error, since such a manifest is not corrupt and
/// its files are not rubbish.
fn parse(store: &dyn Store, bytes: &[u8]) -> Result<Result<Units, String>> {
    let any: AnyLayout = match serde_json::from_slice(bytes) {
        Ok(any) => any,
        Err(why) => return Ok(Err(why.to_string())),
    };
    if any.version != VERSION {
        let found = format!(
            "a manifest of version {}; this gonio reads version {VERSION}: use the gonio that wrote it, or another `[run] work`",
            any.version
        );
        return Err(Error::malformed(store.path(MANIFEST), found));
    }
    let layout: Layout = match serde_json::from_slice(bytes) {
        Ok(layout) => layout,
        Err(why) => return Ok(Err(why.to_string())),
    };
    if layout.checksum != checksum(&layout.units) {
        return Ok(Err("it fails its checksum: it has changed since it was written".to_owned()));
    }
    Ok(fault_of(&layout.units).map_or(Ok(layout.units), Err))
}

/// What units may not be: with names that leave the store, or that appear twice.
fn fault_of(units: &Units) -> Option<String> {
    let mut seen = BTreeSet::new();
    units.values().flatten().find_map(|file| {
        if let Err(why) = check_name(&file.name) {
            return Some(why.to_string());
        }
        (!seen.insert(&file.name)).then(|| format!("file {} is named twice", file.name))
    })
}

/// The first of these files that is not there in its size, in words.
fn missing(store: &dyn Store, files: &[FileEntry]) -> Result<Option<String>> {
    for file in files {
        match store.size(&file.name)? {
            Some(bytes) if bytes == file.bytes => {}
            Some(bytes) => return Ok(Some(format!("{} has {bytes} bytes instead of {}", file.name, file.bytes))),
            None => return Ok(Some(format!("{} is not there", file.name))),
        }
    }
    Ok(None)
}

/// Keeps a corrupt manifest for people to look at, under a name made of its bytes.
fn set_aside(store: &dyn Store, content: &Content) -> Result<String> {
    let name = format!("manifest.corrupt-{:.8}.json", Key(*blake3::hash(content).as_bytes()).to_string());
    let mut draft = store.create(&name)?;
    draft.write_all(content).map_err(Error::io("write", store.path(&name)))?;
    draft.replace()?;
    Ok(name)
}
