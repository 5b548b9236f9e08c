//! What a ledger holds in memory of the units that are done: names and files, and no recipes. Most files bear their
//! unit's name, which is then held once: a hundred thousand units with a file each take about 30 MiB.

use std::collections::{BTreeMap, BTreeSet, HashSet};
use std::fmt;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::Arc;

use super::store::FileEntry;
use super::unit::UnitName;
use crate::base::PhaseName;
use crate::base::key::Key;

/// The units that are done.
#[derive(Debug, Default)]
pub(super) struct Done {
    units: BTreeMap<UnitName, Left>,
    /// Hashes of phase and `what`, to find units by these.
    by_what: BTreeSet<(u64, UnitName)>,
    /// Hashes of the names of all files.
    files: HashSet<u64>,
}

/// What a unit left.
#[derive(Debug)]
pub(super) struct Left {
    /// Which unit of its phase it is.
    pub what: Box<str>,
    files: Box<[ShortEntry]>,
}

/// A file entry whose name is shortened.
#[derive(Debug)]
struct ShortEntry {
    name: Box<str>,
    bytes: u64,
    checksum: Key,
}

/// Stands for the unit's name in a shortened name; no file's name has it.
const UNIT: &str = "\0";

/// A file that belongs to another unit.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Shared<'a> {
    /// The file's name.
    pub file: &'a str,
    /// The unit that the file belongs to.
    pub owner: UnitName,
}

impl fmt::Display for Shared<'_> {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "file {} belongs to unit {}", self.file, self.owner)
    }
}

impl Left {
    /// What this unit left: files with valid names.
    pub(super) fn new(unit: &UnitName, what: &str, files: &[FileEntry]) -> Left {
        let unit = unit.to_string();
        let shorten = |file: &FileEntry| ShortEntry {
            name: file.name.replace(&unit, UNIT).into(),
            bytes: file.bytes,
            checksum: file.checksum,
        };
        Left { what: what.into(), files: files.iter().map(shorten).collect() }
    }

    /// The unit's files.
    pub(super) fn files(&self, unit: &UnitName) -> Arc<[FileEntry]> {
        let unit = unit.to_string();
        let full = |file: &ShortEntry| FileEntry {
            name: file.name.replace(UNIT, &unit),
            bytes: file.bytes,
            checksum: file.checksum,
        };
        self.files.iter().map(full).collect()
    }

    /// Whether one of the unit's files has a name for which `is_it` is true.
    fn any(&self, unit: &UnitName, is_it: impl Fn(&str) -> bool) -> bool {
        self.files(unit).iter().any(|file| is_it(&file.name))
    }
}

impl Done {
    /// These units, save those whose file belongs to a unit before them in the list: `refuse` is told of them, and why.
    pub(super) fn collect(found: Vec<(UnitName, Left)>, mut refuse: impl FnMut(UnitName, String)) -> Done {
        let mut files = HashSet::with_capacity(found.iter().map(|(_, left)| left.files.len()).sum());
        let mut kept: Vec<(UnitName, Left)> = Vec::with_capacity(found.len());
        for (unit, left) in found {
            let own = left.files(&unit);
            let hashes = own.iter().map(|file| hash(&file.name));
            if hashes.clone().any(|hash| files.contains(&hash)) {
                let before = kept.iter().map(|(unit, left)| (unit, left));
                if let Some(shared) = shared(before, &unit, &own) {
                    refuse(unit, shared.to_string());
                    continue;
                }
            }
            files.extend(hashes);
            kept.push((unit, left));
        }
        // Sets that are made at once are packed tightly.
        let by_what = kept.iter().map(|(unit, left)| (hash(&(unit.phase(), &*left.what)), *unit)).collect();
        Done { by_what, units: kept.into_iter().collect(), files }
    }

    pub(super) fn len(&self) -> usize {
        self.units.len()
    }

    pub(super) fn get(&self, unit: &UnitName) -> Option<&Left> {
        self.units.get(unit)
    }

    /// Adds a unit, or gives it other files.
    pub(super) fn insert(&mut self, unit: UnitName, left: Left) {
        self.remove(&unit);
        self.by_what.insert((hash(&(unit.phase(), &*left.what)), unit));
        self.files.extend(left.files(&unit).iter().map(|file| hash(&file.name)));
        self.units.insert(unit, left);
    }

    /// Takes a unit out, and gives its files.
    pub(super) fn remove(&mut self, unit: &UnitName) -> Option<Arc<[FileEntry]>> {
        let left = self.units.remove(unit)?;
        self.by_what.remove(&(hash(&(unit.phase(), &*left.what)), *unit));
        let files = left.files(unit);
        for file in &*files {
            self.files.remove(&hash(&file.name));
        }
        Some(files)
    }

    /// The units of a phase, sorted.
    pub(super) fn of_phase(&self, phase: PhaseName) -> Vec<UnitName> {
        self.units.range(UnitName::range(phase)).map(|(unit, _)| *unit).collect()
    }

    /// The units of a phase with this `what`, sorted.
    pub(super) fn find(&self, phase: PhaseName, what: &str) -> Vec<UnitName> {
        let hash = hash(&(phase, what));
        let (first, last) = UnitName::range(phase).into_inner();
        let same = self.by_what.range((hash, first)..=(hash, last)).map(|(_, unit)| *unit);
        same.filter(|unit| self.get(unit).is_some_and(|left| &*left.what == what)).collect()
    }

    /// Whether a file belongs to a unit. By its hash: of 10^19 strange files one is taken for a unit's.
    pub(super) fn has_file(&self, name: &str) -> bool {
        self.files.contains(&hash(&name))
    }

    /// The first of these files of a unit that belongs to another unit.
    pub(super) fn shared<'a>(&self, unit: &UnitName, files: &'a [FileEntry]) -> Option<Shared<'a>> {
        if !files.iter().any(|file| self.has_file(&file.name)) {
            return None;
        }
        shared(self.units.iter(), unit, files)
    }

    /// The unit with a file for whose name `is_it` is true.
    pub(super) fn owner(&self, is_it: impl Fn(&str) -> bool) -> Option<UnitName> {
        self.units.iter().find(|(unit, left)| left.any(unit, &is_it)).map(|(unit, _)| *unit)
    }
}

/// The first of these files of a unit that belongs to another one of `units`.
fn shared<'a, 'u>(
    units: impl Iterator<Item = (&'u UnitName, &'u Left)> + Clone,
    unit: &UnitName,
    files: &'a [FileEntry],
) -> Option<Shared<'a>> {
    let others = units.filter(|(other, _)| *other != unit);
    files.iter().map(|file| file.name.as_str()).find_map(|file| {
        let owner = others.clone().find(|(other, left)| left.any(other, |name| name == file))?.0;
        Some(Shared { file, owner: *owner })
    })
}

fn hash(value: &impl Hash) -> u64 {
    let mut hasher = DefaultHasher::new();
    value.hash(&mut hasher);
    hasher.finish()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::disk::unit::Recipe;

    #[test]
    fn names_are_held_short_and_told_in_full() {
        let unit = Recipe::new(PhaseName::Mock, "7").unit();
        let names =
            [format!("a/{unit}.x-1.seg"), "scene.cache".to_owned(), format!("{unit}/{unit}"), "mock-".to_owned()];
        let entry = |name: &String| FileEntry { name: name.clone(), bytes: 3, checksum: Key([7; 32]) };
        let files: Vec<FileEntry> = names.iter().map(entry).collect();
        let left = Left::new(&unit, "7", &files);
        assert_eq!(&*left.files(&unit), files);
        assert_eq!(left.files.iter().map(|file| file.name.len()).collect::<Vec<_>>(), [11, 11, 3, 5]);
    }
}
