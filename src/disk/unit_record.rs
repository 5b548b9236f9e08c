//! Unit records: the files that say which units are done. `units/NAME.json` is the record of unit NAME, sealed JSON
//! (`sealed_json`) in one line:
//!
//! ```text
//! version    1
//! checksum   BLAKE3 in hex of `unit`
//! unit       { phase, what, ingredients: { NAME: VALUE, .. }, files: [ { name, bytes, checksum }, .. ] }
//! ```
//!
//! NAME is the name that the recipe gives. The files are in the store, outside of `units/` and `corrupt/`; each is named
//! once. A record is created whole under its name, first wins, and never written again.

use std::collections::BTreeMap;

use serde::{Deserialize, Serialize};

use super::corrupt::{CORRUPT, OBSTACLE};
use super::names::check_name;
use super::sealed_json::{JsonSeal, Unreadable};
use super::store::{FileEntry, Store};
use super::unit::{Recipe, UnitName, name_of};
use crate::base::{Error, PhaseName, Result};

/// The folder of the unit records.
pub(crate) const UNITS: &str = "units";

/// The version of the layout above.
pub(super) const VERSION: u32 = 1;

const SEAL: JsonSeal = JsonSeal { body: "unit", version: VERSION, kind: "unit record" };

/// What a unit record says.
#[derive(Debug, Clone, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub(super) struct UnitRecord {
    phase: PhaseName,
    /// Which unit of its phase it is.
    pub what: String,
    ingredients: BTreeMap<String, String>,
    /// The files that the unit left.
    pub files: Vec<FileEntry>,
}

/// Why a unit does not count as done although it has a record.
#[derive(Debug)]
pub(super) enum Unsound {
    /// The record cannot be believed: what was found, in words.
    Corrupt(String),
    /// A file is gone or has another size.
    Lost {
        /// Which unit of its phase it is.
        what: String,
        /// What was found, in words.
        why: String,
        /// The file.
        at_fault: String,
        /// All of the unit's files.
        files: Vec<FileEntry>,
    },
}

/// The name of the file of a unit's record.
pub(super) fn file_of(unit: &UnitName) -> String {
    format!("{UNITS}/{unit}.json")
}

/// The unit whose record has this name; `None` for any other file.
pub(super) fn unit_of(file: &str) -> Option<UnitName> {
    file.strip_prefix(UNITS)?.strip_prefix('/')?.strip_suffix(".json")?.parse().ok()
}

impl UnitRecord {
    /// The record of a unit that left these files.
    pub(super) fn new(recipe: &Recipe, files: Vec<FileEntry>) -> UnitRecord {
        let owned = |(name, value): (&str, &str)| (name.to_owned(), value.to_owned());
        UnitRecord {
            phase: recipe.phase(),
            what: recipe.what().to_owned(),
            ingredients: recipe.ingredients().map(owned).collect(),
            files,
        }
    }

    /// The unit's recipe.
    pub(super) fn into_recipe(self) -> Recipe {
        Recipe::new(self.phase, self.what).with_all(self.ingredients)
    }

    /// The bytes of the record's file.
    pub(super) fn seal(&self) -> serde_json::Result<Vec<u8>> {
        SEAL.seal(self)
    }

    /// Reads the record of a unit and believes nothing: neither the record nor that the unit's files are there.
    ///
    /// # Errors
    /// The record is of another version; the store fails, or has no such record.
    pub(super) fn read(store: &dyn Store, unit: &UnitName) -> Result<Result<UnitRecord, Unsound>> {
        let name = file_of(unit);
        if store.is_obstructed(&name)? {
            return Ok(Err(Unsound::Corrupt(OBSTACLE.to_owned())));
        }
        let record = match SEAL.open::<UnitRecord>(&store.read(&name)?) {
            Ok(record) => record,
            Err(Unreadable::Corrupt(why)) => return Ok(Err(Unsound::Corrupt(why))),
            Err(Unreadable::OtherVersion(why)) => {
                return Err(Error::invalid(format!("{}: {why}", store.path(&name).display())));
            }
        };
        // IMPORTANT: the name comes first. The files of a lost unit are removed, and those in the record of another unit
        // are not this one's.
        let found = name_of(record.phase, &record.what, &record.ingredients);
        if found != *unit {
            return Ok(Err(Unsound::Corrupt(format!("holds unit {found} under the name of another unit"))));
        }
        if let Err(why) = check_files(&record.files) {
            return Ok(Err(Unsound::Corrupt(why)));
        }
        if let Some(Missing { file, why }) = missing(store, &record.files)? {
            let at_fault = file.to_owned();
            return Ok(Err(Unsound::Lost { what: record.what, why, at_fault, files: record.files }));
        }
        Ok(Ok(record))
    }
}

/// Refuses files that a unit cannot own, in words: outside the store, in its own folders, or named twice.
pub(super) fn check_files(files: &[FileEntry]) -> Result<(), String> {
    for FileEntry { name, .. } in files {
        check_name(name).map_err(|why| why.to_string())?;
        if [UNITS, CORRUPT].iter().any(|folder| name.split('/').next() == Some(folder)) {
            return Err(format!("file {name} is in a folder that no unit may write to"));
        }
    }
    let mut names: Vec<&str> = files.iter().map(|file| file.name.as_str()).collect();
    names.sort_unstable();
    let twice = names.windows(2).find(|pair| pair[0] == pair[1]);
    twice.map_or(Ok(()), |pair| Err(format!("file {} is named twice", pair[0])))
}

/// A file that is not in the store as its entry describes it.
pub(super) struct Missing<'a> {
    /// The file's name.
    pub file: &'a str,
    /// What was found, in words.
    pub why: String,
}

/// The first of these files that is not in the store in its size.
pub(super) fn missing<'a>(store: &dyn Store, files: &'a [FileEntry]) -> Result<Option<Missing<'a>>> {
    for FileEntry { name: file, bytes: wanted, .. } in files {
        match store.size(file)? {
            Some(bytes) if bytes == *wanted => {}
            Some(bytes) => {
                return Ok(Some(Missing { file, why: format!("{file} has {bytes} bytes instead of {wanted}") }));
            }
            None if store.is_obstructed(file)? => {
                return Ok(Some(Missing { file, why: format!("{file} {OBSTACLE}") }));
            }
            None => return Ok(Some(Missing { file, why: format!("{file} is not there") })),
        }
    }
    Ok(None)
}
