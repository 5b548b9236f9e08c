//! Holds the files of all units against their records. Nothing is changed, and a run may be under way meanwhile.

use super::corrupt::OBSTACLE;
use super::ledger::{Findings, Ledger, read_record};
use super::store::{FileEntry, Store};
use super::unit::{UnitName, in_words};
use crate::base::{Error, PhaseName, Result};

/// A file of a run that is not as it was written.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Rotten {
    /// The file's name in the store.
    pub file: String,
    /// The unit that the file belongs to, as "cast 17"; `None` if it belongs to none.
    pub unit: Option<String>,
    /// What was found, in words.
    pub why: String,
}

/// What was held against its record.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub(crate) struct Held {
    /// The number of units that are done.
    pub units: u64,
    /// Files of those units.
    pub files: u64,
    /// Bytes of those files.
    pub bytes: u64,
    /// Files that are not as their records say, and records that cannot be believed.
    pub rotten: Vec<Rotten>,
}

impl Rotten {
    /// A file of no unit, given why it cannot be read.
    pub(crate) fn new(file: impl Into<String>, why: &Error) -> Rotten {
        Rotten { file: file.into(), unit: None, why: found(why) }
    }
}

/// Reads every file of every unit that is done, and compares it with its unit's record. `findings` are those of reading the
/// ledger.
///
/// # Errors
/// A unit record cannot be read.
pub(crate) fn verify(store: &dyn Store, ledger: &Ledger, findings: &Findings) -> Result<Held> {
    let mut held = Held::default();
    for finding in findings.corrupt.iter().chain(&findings.lost) {
        // Another process may have done the unit over since.
        if matches!(read_record(store, &finding.unit)?, Some(Err(_))) {
            let phase = finding.unit.phase();
            let unit = finding.what.as_ref().map_or_else(|| format!("a unit of {phase}"), |what| in_words(phase, what));
            held.rotten.push(Rotten { file: finding.file.clone(), unit: Some(unit), why: finding.why.clone() });
        }
    }
    for phase in PhaseName::ALL {
        for unit in ledger.of_phase(phase) {
            held.units += 1;
            for file in ledger.files(&unit).unwrap_or_default().iter() {
                held.files += 1;
                held.bytes += file.bytes;
                if let Some(why) = fault(store, &unit, file)? {
                    let unit = in_words(phase, &ledger.what(&unit).unwrap_or_default());
                    held.rotten.push(Rotten { file: file.name.clone(), unit: Some(unit), why });
                }
            }
        }
    }
    Ok(held)
}

/// What is wrong with a unit's file, in words. A file that the unit's record no longer names is nobody's concern: a record
/// goes before its files do.
fn fault(store: &dyn Store, unit: &UnitName, file: &FileEntry) -> Result<Option<String>> {
    let why = if store.is_obstructed(&file.name)? {
        OBSTACLE.to_owned()
    } else {
        match file.check(store) {
            Ok(()) => return Ok(None),
            Err(why) => found(&why),
        }
    };
    let named = match read_record(store, unit)? {
        Some(Ok(record)) => record.files.contains(file),
        // The record has become unsound since it was read.
        Some(Err(_)) => true,
        None => false,
    };
    Ok(named.then_some(why))
}

/// What was found, in words, without the file's path.
fn found(why: &Error) -> String {
    match why {
        Error::Malformed { found, .. } => found.clone(),
        Error::Io { verb, source, .. } => format!("cannot {verb} it: {source}"),
        why => why.to_string(),
    }
}
