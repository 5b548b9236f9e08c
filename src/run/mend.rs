//! Mending: a file that turns out to be corrupt is set aside, and the unit that it belonged to is done over, at once and once
//! for each file.

use std::collections::BTreeSet;
use std::path::PathBuf;

use crate::base::units::Bytes;
use crate::base::{Error, PhaseName, Result};
use crate::disk::{FileEntry, Ledger, Store, UnitName};
use crate::flow::StopSignal;
use crate::phases::{Progress, Unit};

/// The bytes that are checked without a word.
const MUCH: u64 = 4 << 30;

/// What was mended in a call of `run`.
pub(super) struct Mending<'a> {
    store: &'a dyn Store,
    ledger: &'a Ledger,
    /// Where the run says how far it is.
    pub progress: &'a Progress,
    /// Files that were set aside.
    set_aside: BTreeSet<PathBuf>,
    /// Units whose files were found to be as their records say.
    sound: BTreeSet<UnitName>,
    /// Whether files were set aside by a check, and the phases have to go on from what is left.
    again: bool,
}

impl<'a> Mending<'a> {
    /// Nothing mended yet.
    pub(super) fn new(store: &'a dyn Store, ledger: &'a Ledger, progress: &'a Progress) -> Self {
        let (set_aside, sound) = (BTreeSet::new(), BTreeSet::new());
        Mending { store, ledger, progress, set_aside, sound, again: false }
    }

    /// Holds the files of units of a phase against their records: all of them, so that what is corrupt is done over together.
    ///
    /// # Errors
    /// Some of the files are corrupt and have been set aside; the run was asked to stop; the store fails.
    pub(super) fn check(&mut self, phase: PhaseName, done: &[Unit], stop: &StopSignal) -> Result<()> {
        let unchecked = done.iter().filter(|unit| !self.sound.contains(&unit.name));
        let files = unchecked.filter_map(|unit| Some((unit.name, self.ledger.files(&unit.name)?)));
        let files: Vec<_> = files.collect();
        let bytes: u64 = files.iter().flat_map(|(_, files)| files.iter()).map(|file| file.bytes).sum();
        if bytes > MUCH {
            self.progress.note(format!("{phase}: {} from before are held against their checksums", Bytes(bytes)));
        }
        for (unit, files) in files {
            if stop.draining() {
                return Err(Error::Interrupted);
            }
            let check = |file: &FileEntry| file.check(self.store);
            match files.iter().try_for_each(check) {
                Ok(()) => drop(self.sound.insert(unit)),
                Err(why) => {
                    self.set_aside(why)?;
                    self.again = true;
                }
            }
        }
        if self.again { Err(Error::invalid(format!("corrupt files of {phase} were set aside"))) } else { Ok(()) }
    }

    /// Sets aside what made an attempt fail, if that was a corrupt file of a unit, so that the unit is done over.
    ///
    /// # Errors
    /// The error itself, if it was anything else, or if the file was set aside before: then the disk spoils whatever it is given.
    pub(super) fn after(&mut self, why: Error) -> Result<()> {
        if std::mem::take(&mut self.again) { Ok(()) } else { self.set_aside(why) }
    }

    fn set_aside(&mut self, why: Error) -> Result<()> {
        let Some(file) = why.malformed_file().filter(|file| self.set_aside.insert(file.to_path_buf())) else {
            return Err(why);
        };
        let Some(found) = self.ledger.set_aside(file)? else { return Err(why) };
        self.progress.note(format!("unit {} is done over; its corrupt file is now {}: {why}", found.unit, found.kept));
        Ok(())
    }
}
