//! The manifest: which units of work are done, and which files they left. `manifest.json`, one object:
//!
//! ```text
//! version    2
//! checksum   BLAKE3 in hex of `units` as compact JSON with sorted keys
//! units      by unit name: { recipe: { what, made_of }, files: a list of { name, bytes, checksum } }
//! ```
//!
//! It is replaced as a whole and last of all: a unit is done when the manifest that names it is on the disk. A file
//! belongs to one unit. A unit is committed once.
//!
//! After it, the same bytes are written once more, as [`COPY`]: should the manifest's bytes go bad, the copy still knows
//! every unit, or every one but the last.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Write;
use std::path::Path;
use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::Recipe;
use super::store::{FileEntry, Store, check_name};
use crate::base::key::Key;
use crate::base::{Error, Result};

/// The manifest's name in the store.
pub const MANIFEST: &str = "manifest.json";

/// The name of its copy.
pub const COPY: &str = "manifest.copy.json";

/// The folder of what was corrupt, kept for people to look at.
const CORRUPT: &str = "corrupt";

/// The version of the layout above.
pub const VERSION: u32 = 2;

/// A unit that is done.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Unit {
    /// What it is made of.
    pub recipe: Recipe,
    /// What it left.
    pub files: Vec<FileEntry>,
}

/// Units by name, which is [`Recipe::unit`].
pub type Units = BTreeMap<String, Unit>;

/// The manifest of an open run.
#[derive(Debug)]
pub struct Manifest {
    store: Arc<dyn Store>,
    units: Units,
}

/// What was found when a run was opened; all empty where the last run ended well.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Opening {
    /// A manifest that could not be read: where it was put, and what was wrong with it.
    pub set_aside: Option<(String, String)>,
    /// Whether the copy stood in for it. If not, all units are lost.
    pub copied: bool,
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
        if let Some(found) = parse(&*store, MANIFEST)? {
            match found {
                Ok(found) => units = found,
                Err(fault) => {
                    // A copy that is corrupt too, or of another version, is none.
                    if let Ok(Some(Ok(copied))) = parse(&*store, COPY) {
                        (units, opening.copied) = (copied, true);
                    }
                    opening.set_aside = Some((set_aside(&*store, MANIFEST)?, fault));
                }
            }
        }
        let mut corrupt = Vec::new();
        for (name, unit) in &units {
            if let Some((file, fault)) = missing(&*store, &unit.files)? {
                corrupt.push(file.to_owned());
                opening.lost.push((name.clone(), fault));
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
        for file in corrupt {
            if manifest.store.size(&file)?.is_some() {
                set_aside(&*manifest.store, &file)?;
            }
        }
        opening.swept = manifest.sweep(owned)?;
        Ok((manifest, opening))
    }

    /// Reads the manifest of a run that may be under way, and changes nothing. Without one, no unit is done.
    ///
    /// # Errors
    /// The manifest is corrupt or of another version; the store fails.
    pub fn read(store: Arc<dyn Store>) -> Result<Manifest> {
        let units = match parse(&*store, MANIFEST)? {
            Some(found) => found.map_err(|fault| Error::malformed(store.path(MANIFEST), fault))?,
            None => Units::new(),
        };
        Ok(Manifest { store, units })
    }

    /// All units that are done, sorted by name.
    pub fn units(&self) -> &Units {
        &self.units
    }

    /// The units of a kind that are done.
    pub fn of_kind(&self, kind: &str) -> impl Iterator<Item = (&str, &Unit)> {
        self.units.iter().filter(move |(_, unit)| unit.recipe.kind() == kind).map(|(name, unit)| (name.as_str(), unit))
    }

    /// The files of a unit, if it is done.
    pub fn files(&self, unit: &str) -> Option<&[FileEntry]> {
        self.units.get(unit).map(|unit| unit.files.as_slice())
    }

    /// Makes units done; their files are committed already.
    ///
    /// # Errors
    /// A unit that is done already, a file that is not in the store as it is said to be or belongs to another unit; the
    /// store fails. Then nothing has changed.
    pub fn commit(&mut self, units: impl IntoIterator<Item = (Recipe, Vec<FileEntry>)>) -> Result<()> {
        let mut all = self.units.clone();
        for (recipe, files) in units {
            let name = recipe.unit();
            if let Some((_, fault)) = missing(&*self.store, &files)? {
                return Err(Error::invalid(format!("unit {name} cannot be committed: {fault}")));
            }
            if all.insert(name.clone(), Unit { recipe, files }).is_some() {
                return Err(Error::invalid(format!("unit {name} is committed already")));
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
        let forgotten: Vec<Unit> = units.into_iter().filter_map(|unit| all.remove(unit)).collect();
        // IMPORTANT: the manifest stops naming a file before the file is removed.
        self.adopt(all)?;
        forgotten.iter().flat_map(|unit| &unit.files).try_for_each(|file| self.store.remove(&file.name))
    }

    /// Forgets the unit that a corrupt file belongs to, keeps that file for people to look at and removes the unit's
    /// others. Gives the unit's name and where the file is now; `None` if the path is of no unit's file.
    pub fn set_aside(&mut self, path: &Path) -> Result<Option<(String, String)>> {
        let store = Arc::clone(&self.store);
        let has_it = |unit: &Unit| unit.files.iter().any(|file| store.path(&file.name) == path);
        let Some(name) = self.units.iter().find(|(_, unit)| has_it(unit)).map(|(name, _)| name.clone()) else {
            return Ok(None);
        };
        let mut all = self.units.clone();
        let files = all.remove(&name).map(|unit| unit.files).unwrap_or_default();
        self.adopt(all)?;
        let mut kept = String::new();
        for file in files {
            if store.path(&file.name) == path {
                kept = set_aside(&*store, &file.name)?;
            } else {
                store.remove(&file.name)?;
            }
        }
        Ok(Some((name, kept)))
    }

    /// Makes these the units that are done, on the disk and then here.
    fn adopt(&mut self, units: Units) -> Result<()> {
        let before = std::mem::replace(&mut self.units, units);
        self.write().inspect_err(|_| self.units = before)
    }

    fn write(&self) -> Result<()> {
        let layout = Layout { version: VERSION, checksum: checksum(&self.units), units: self.units.clone() };
        let failed = |name| Error::io("write", self.store.path(name));
        let mut text = serde_json::to_vec_pretty(&layout).map_err(|why| failed(MANIFEST)(why.into()))?;
        text.push(b'\n');
        for name in [MANIFEST, COPY] {
            let mut draft = self.store.create(name)?;
            draft.write_all(&text).map_err(failed(name))?;
            draft.replace()?;
        }
        Ok(())
    }

    fn sweep(&self, owned: &[&str]) -> Result<Vec<String>> {
        let named: BTreeSet<&str> =
            self.units.values().flat_map(|unit| &unit.files).map(|file| file.name.as_str()).collect();
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
    Key::of_bytes(&serde_json::to_vec(units).unwrap_or_default()).to_string()
}

/// The units of the manifest under this name, or what is wrong with it; `None` if there is none. Another version is an
/// error, since such a manifest is not corrupt and its files are not rubbish.
fn parse(store: &dyn Store, name: &str) -> Result<Option<Result<Units, String>>> {
    if store.size(name)?.is_none() {
        return Ok(None);
    }
    let bytes = store.open(name)?;
    let any: AnyLayout = match serde_json::from_slice(&bytes) {
        Ok(any) => any,
        Err(why) => return Ok(Some(Err(why.to_string()))),
    };
    if any.version != VERSION {
        let found = format!(
            "a manifest of version {}; this gonio reads version {VERSION}: use the gonio that wrote it, or another `[run] work`",
            any.version
        );
        return Err(Error::malformed(store.path(name), found));
    }
    let layout: Layout = match serde_json::from_slice(&bytes) {
        Ok(layout) => layout,
        Err(why) => return Ok(Some(Err(why.to_string()))),
    };
    if layout.checksum != checksum(&layout.units) {
        return Ok(Some(Err("it fails its checksum: it has changed since it was written".to_owned())));
    }
    Ok(Some(fault_of(&layout.units).map_or(Ok(layout.units), Err)))
}

/// What units may not be: under another's name, with files whose names leave the store, or appear twice.
fn fault_of(units: &Units) -> Option<String> {
    if let Some((name, _)) = units.iter().find(|(name, unit)| **name != unit.recipe.unit()) {
        return Some(format!("unit {name} is not what its name says"));
    }
    let mut seen = BTreeSet::new();
    units.values().flat_map(|unit| &unit.files).find_map(|file| {
        if let Err(why) = check_name(&file.name) {
            return Some(why.to_string());
        }
        (!seen.insert(&file.name)).then(|| format!("file {} is named twice", file.name))
    })
}

/// The first of these files that is not there in its size, and what was found, in words.
fn missing<'a>(store: &dyn Store, files: &'a [FileEntry]) -> Result<Option<(&'a str, String)>> {
    for file in files {
        match store.size(&file.name)? {
            Some(bytes) if bytes == file.bytes => {}
            Some(bytes) => {
                let fault = format!("{} has {bytes} bytes instead of {}", file.name, file.bytes);
                return Ok(Some((&file.name, fault)));
            }
            None => return Ok(Some((&file.name, format!("{} is not there", file.name)))),
        }
    }
    Ok(None)
}

/// Keeps a corrupt file for people to look at; of one name only the last.
fn set_aside(store: &dyn Store, name: &str) -> Result<String> {
    let kept = format!("{CORRUPT}/{}", name.rsplit('/').next().unwrap_or(name));
    store.rename(name, &kept)?;
    Ok(kept)
}
