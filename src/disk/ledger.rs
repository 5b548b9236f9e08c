//! The ledger: the units that are done. A unit is done when its record (`unit_record`) lies in the folder `units/` and
//! its files are there: files first, then the record. The record is created so that the first one wins, in one step of
//! the filesystem; so any number of processes may do the same unit, and all go on with the winner's files.
//!
//! A unit whose record is corrupt or whose files are gone is not done, and no other unit is touched by that. A record
//! goes before its files do: what no record names is rubbish, which the holder of the lock sweeps.

use std::collections::BTreeMap;
use std::io::{ErrorKind, Write};
use std::path::Path;
use std::sync::{Arc, PoisonError, RwLock, RwLockReadGuard, RwLockWriteGuard};

use rayon::prelude::*;

use super::corrupt;
use super::done::{Done, Left};
use super::names::Committed;
use super::store::{FileEntry, Store};
use super::unit::{Recipe, UnitName};
use super::unit_record::{Missing, UNITS, UnitRecord, Unsound, check_files, file_of, missing, unit_of};
use crate::base::{Error, PhaseName, Result};

/// How often a commit meets a record that cannot be believed and moves it out of the way.
const TRIES: usize = 3;

/// The units of a run that are done. Threads may share it.
#[derive(Debug)]
pub struct Ledger {
    store: Arc<dyn Store>,
    done: RwLock<Done>,
}

/// The units that have a record and still are not done, sorted; both lists are empty where nothing went wrong.
#[derive(Debug, Clone, Default, PartialEq, Eq)]
pub struct Findings {
    /// Units whose records cannot be believed.
    pub corrupt: Vec<Finding>,
    /// Units whose files are gone or have another size.
    pub lost: Vec<Finding>,
}

/// A unit that has to be done again.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Finding {
    /// The unit.
    pub unit: UnitName,
    /// Which unit of its phase it is, where its record can be believed.
    pub what: Option<String>,
    /// The file at fault: the unit's record or one of its files.
    pub file: String,
    /// What was found, in words.
    pub why: String,
    /// The name under which the corrupt file is kept, if it was set aside.
    pub kept: Option<String>,
}

/// A unit that was forgotten because one of its files is corrupt.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct SetAside {
    /// The unit.
    pub unit: UnitName,
    /// The name under which the corrupt file is kept.
    pub kept: String,
}

impl Findings {
    /// Whether nothing went wrong.
    pub fn is_empty(&self) -> bool {
        self.corrupt.is_empty() && self.lost.is_empty()
    }
}

impl Ledger {
    /// Reads the ledger of a run that may be under way, and changes nothing.
    ///
    /// # Errors
    /// A unit record is of another version; the store fails.
    pub fn read(store: Arc<dyn Store>) -> Result<(Ledger, Findings)> {
        let (done, unsound) = look(&*store)?;
        let mut findings = Findings::default();
        unsound.iter().for_each(|(unit, unsound)| findings.add(*unit, unsound, None));
        Ok((Ledger { store, done: RwLock::new(done) }, findings))
    }

    /// Opens the ledger for the holder of the run's lock: reads it, sets aside corrupt unit records, and removes the
    /// records and files of units that lost a file.
    ///
    /// # Errors
    /// As for [`Ledger::read`].
    pub fn open(store: Arc<dyn Store>) -> Result<(Ledger, Findings)> {
        let (done, unsound) = look(&*store)?;
        let mut findings = Findings::default();
        for (unit, unsound) in &unsound {
            let kept = remove_record(&*store, unit, unsound)?;
            findings.add(*unit, unsound, kept);
        }
        // IMPORTANT: no record names a file any more when the file is removed.
        if !unsound.is_empty() {
            store.sync(UNITS)?;
        }
        for (unit, unsound) in &unsound {
            let Unsound::Lost { at_fault, files, .. } = unsound else { continue };
            for file in files {
                let shared = done.shared(unit, std::slice::from_ref(file)).is_some();
                let obstructed = store.is_obstructed(&file.name)?;
                if shared || (!obstructed && store.size(&file.name)?.is_none()) {
                    continue;
                }
                if obstructed || file.name == *at_fault {
                    findings.keep(unit, corrupt::set_aside(&*store, &file.name)?);
                } else {
                    corrupt::remove(&*store, &file.name)?;
                }
            }
        }
        Ok((Ledger { store, done: RwLock::new(done) }, findings))
    }

    /// Removes rubbish and names it: temporary files, and files that an attempt at this run made and no unit record names.
    /// Only the holder of the lock may sweep.
    pub fn sweep(&self) -> Result<Vec<String>> {
        let mut swept = self.store.sweep()?;
        for name in self.store.list("")? {
            if self.store.made(&name) && !corrupt::is_kept(&name) && !self.done().has_file(&name) {
                corrupt::remove(&*self.store, &name)?;
                swept.push(name);
            }
        }
        Ok(swept)
    }

    /// Sets aside whatever keeps a file from having one of these names, and gives the names under which it is kept.
    pub fn clear(&self, names: &[&str]) -> Result<Vec<String>> {
        let mut kept = Vec::new();
        for name in names {
            if self.store.is_obstructed(name)? {
                kept.push(corrupt::set_aside(&*self.store, name)?);
            }
        }
        Ok(kept)
    }

    /// Makes a unit done, unless another process was faster: then the ledger goes on with that one's files, and removes
    /// those of `files` that the winner's record does not name. All of `files` are committed already.
    ///
    /// # Errors
    /// A file that is not in the store as its entry says, that is named twice or belongs to another unit; the store
    /// fails.
    pub fn commit(&self, recipe: &Recipe, files: Vec<FileEntry>) -> Result<Committed> {
        let unit = recipe.unit();
        let refuse = |why: String| Error::invalid(format!("unit {unit} cannot be committed: {why}"));
        check_files(&files).map_err(refuse)?;
        if let Some(Missing { why, .. }) = missing(&*self.store, &files)? {
            return Err(refuse(why));
        }
        if let Some(shared) = self.done().shared(&unit, &files) {
            return Err(refuse(shared.to_string()));
        }
        let name = file_of(&unit);
        let record = UnitRecord::new(recipe, files);
        let text = record.seal().map_err(|why| Error::io("write", self.store.path(&name))(why.into()))?;
        for _ in 0..TRIES {
            if self.create(&name, &text)? == Committed::Now {
                self.change().insert(unit, left(&unit, &record));
                return Ok(Committed::Now);
            }
            match read_record(&*self.store, &unit)? {
                Some(Ok(winner)) => {
                    self.change().insert(unit, left(&unit, &winner));
                    let kept = |file: &FileEntry| winner.files.iter().any(|winning| winning.name == file.name);
                    for file in record.files.iter().filter(|file| !kept(file)) {
                        corrupt::remove(&*self.store, &file.name)?;
                    }
                    return Ok(Committed::Already);
                }
                // A record that cannot be believed does not win: it goes, and ours takes its place.
                Some(Err(unsound)) => {
                    remove_record(&*self.store, &unit, &unsound)?;
                }
                None => {}
            }
        }
        Err(Error::malformed(self.store.path(&name), "the unit record is corrupt however often it is written"))
    }

    /// Whether a unit is done.
    pub fn is_done(&self, unit: &UnitName) -> bool {
        self.done().get(unit).is_some()
    }

    /// The files of a unit, if it is done.
    pub fn files(&self, unit: &UnitName) -> Option<Arc<[FileEntry]>> {
        self.done().get(unit).map(|left| left.files(unit))
    }

    /// Which unit of its phase a unit is ([`Recipe::what`]), if it is done.
    pub fn what(&self, unit: &UnitName) -> Option<String> {
        self.done().get(unit).map(|left| left.what.to_string())
    }

    /// The recipe of a unit, read from its record.
    ///
    /// # Errors
    /// The record is gone, corrupt or of another version, or the unit's files are gone.
    pub fn recipe(&self, unit: &UnitName) -> Result<Recipe> {
        match UnitRecord::read(&*self.store, unit)? {
            Ok(record) => Ok(record.into_recipe()),
            Err(Unsound::Corrupt(why) | Unsound::Lost { why, .. }) => {
                Err(Error::malformed(self.store.path(&file_of(unit)), why))
            }
        }
    }

    /// The units of a phase that are done, sorted.
    pub fn of_phase(&self, phase: PhaseName) -> Vec<UnitName> {
        self.done().of_phase(phase)
    }

    /// The units of a phase that are done and have this [`Recipe::what`], sorted: of one recipe or of several.
    pub fn find(&self, phase: PhaseName, what: &str) -> Vec<UnitName> {
        self.done().find(phase, what)
    }

    /// The number of units that are done.
    pub fn len(&self) -> usize {
        self.done().len()
    }

    /// Whether no unit is done.
    pub fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Forgets units, if they are done, and removes their files.
    pub fn forget(&self, units: impl IntoIterator<Item = UnitName>) -> Result<()> {
        let mut forgotten = Vec::new();
        for unit in units {
            if self.is_done(&unit) {
                corrupt::remove(&*self.store, &file_of(&unit))?;
                forgotten.extend(self.change().remove(&unit));
            }
        }
        // IMPORTANT: no record names a file any more when the file is removed.
        if !forgotten.is_empty() {
            self.store.sync(UNITS)?;
        }
        let mut files = forgotten.iter().flat_map(|files| files.iter());
        files.try_for_each(|file| corrupt::remove(&*self.store, &file.name))
    }

    /// Forgets the unit that a corrupt file belongs to, keeps that file for people to look at, and removes the unit's
    /// other files. The file may be the unit's record. `None` if the path is not of a unit that is done. Where another
    /// process has done the unit again since, the ledger goes on with that one's files.
    pub fn set_aside(&self, path: &Path) -> Result<Option<SetAside>> {
        let store = &*self.store;
        let is_it = |name: &str| store.path(name) == path;
        let named = path.file_name().and_then(|name| unit_of(&format!("{UNITS}/{}", name.to_str()?)));
        let of_record = named.filter(|unit| self.is_done(unit) && is_it(&file_of(unit)));
        let of_file = || self.done().owner(is_it);
        let Some(unit) = of_record.or_else(of_file) else { return Ok(None) };
        if of_record.is_none()
            && let Some(kept) = self.done_again(&unit, path)?
        {
            return Ok(Some(SetAside { unit, kept }));
        }
        let record = file_of(&unit);
        let mut kept = String::new();
        if of_record.is_some() {
            kept = corrupt::set_aside(store, &record)?;
        } else {
            corrupt::remove(store, &record)?;
        }
        let files = self.change().remove(&unit);
        // IMPORTANT: no record names a file any more when the file is removed.
        store.sync(UNITS)?;
        for file in files.iter().flat_map(|files| files.iter()) {
            if is_it(&file.name) {
                kept = corrupt::set_aside(store, &file.name)?;
            } else {
                corrupt::remove(store, &file.name)?;
            }
        }
        Ok(Some(SetAside { unit, kept }))
    }

    /// Takes over a unit's record if it no longer names the file at this path, and says where that file must be now.
    fn done_again(&self, unit: &UnitName, path: &Path) -> Result<Option<String>> {
        let Some(Ok(record)) = read_record(&*self.store, unit)? else { return Ok(None) };
        if record.files.iter().any(|file| self.store.path(&file.name) == path) {
            return Ok(None);
        }
        self.change().insert(*unit, left(unit, &record));
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        Ok(Some(corrupt::kept_as(&name)))
    }

    fn create(&self, name: &str, text: &[u8]) -> Result<Committed> {
        let mut draft = self.store.create(name)?;
        draft.write_all(text).map_err(Error::io("write", draft.path()))?;
        draft.commit_first().map(|(_, committed)| committed)
    }

    fn done(&self) -> RwLockReadGuard<'_, Done> {
        // Nothing that may panic runs while the lock is held.
        self.done.read().unwrap_or_else(PoisonError::into_inner)
    }

    fn change(&self) -> RwLockWriteGuard<'_, Done> {
        self.done.write().unwrap_or_else(PoisonError::into_inner)
    }
}

impl Findings {
    fn add(&mut self, unit: UnitName, unsound: &Unsound, kept: Option<String>) {
        let (list, what, file, why) = match unsound {
            Unsound::Corrupt(why) => (&mut self.corrupt, None, file_of(&unit), why),
            Unsound::Lost { what, why, at_fault, .. } => (&mut self.lost, Some(what.clone()), at_fault.clone(), why),
        };
        list.push(Finding { unit, what, file, why: why.clone(), kept });
    }

    /// Notes where the file is kept that a unit lost.
    fn keep(&mut self, unit: &UnitName, kept: String) {
        let found = self.lost.iter_mut().find(|finding| finding.unit == *unit);
        found.into_iter().for_each(|finding| finding.kept = Some(kept.clone()));
    }
}

fn left(unit: &UnitName, record: &UnitRecord) -> Left {
    Left::new(unit, &record.what, &record.files)
}

/// Reads all unit records: the units that are done, and those that only have a record.
fn look(store: &dyn Store) -> Result<(Done, BTreeMap<UnitName, Unsound>)> {
    let (files, obstacles) = (store.list(UNITS)?, store.obstacles(UNITS)?);
    let units: Vec<UnitName> = files.iter().chain(&obstacles).filter_map(|name| unit_of(name)).collect();
    let read = |unit: UnitName| match read_record(store, &unit) {
        Ok(found) => found.map(|found| Ok((unit, found.map(|record| left(&unit, &record))))),
        Err(why) => Some(Err(why)),
    };
    let found = units.into_par_iter().filter_map(read).collect::<Result<Vec<_>>>()?;
    let (mut sound, mut unsound) = (Vec::with_capacity(found.len()), BTreeMap::new());
    for (unit, found) in found {
        match found {
            Ok(left) => sound.push((unit, left)),
            Err(why) => drop(unsound.insert(unit, why)),
        }
    }
    let done = Done::collect(sound, |unit, why| drop(unsound.insert(unit, Unsound::Corrupt(why))));
    Ok((done, unsound))
}

/// Reads a unit's record; `None` if it is gone.
pub(super) fn read_record(store: &dyn Store, unit: &UnitName) -> Result<Option<Result<UnitRecord, Unsound>>> {
    match UnitRecord::read(store, unit) {
        Ok(found) => Ok(Some(found)),
        Err(Error::Io { source, .. }) if source.kind() == ErrorKind::NotFound => Ok(None),
        Err(why) => Err(why),
    }
}

/// Removes the record of a unit that is not done, or moves it where it is kept, and gives its new name.
fn remove_record(store: &dyn Store, unit: &UnitName, unsound: &Unsound) -> Result<Option<String>> {
    match unsound {
        Unsound::Corrupt(_) => corrupt::set_aside(store, &file_of(unit)).map(Some),
        Unsound::Lost { .. } => corrupt::remove(store, &file_of(unit)).map(|()| None),
    }
}
