//! A disk whose power is cut, for tests: what of a journal's steps lies on it afterwards.
//!
//! Only a sync makes durable: that of a file its bytes, that of a folder the names in it. Of all other changes any may be
//! lost and any may be kept, whatever their order. The bytes of one write are lost by blocks; where a block is lost and one
//! after it is kept, zeros or the old bytes lie between. A name may be kept whose file's bytes are lost. Renaming within a
//! folder is one change; between folders the old name goes only if the new one is there.

use std::collections::{BTreeMap, HashMap};
use std::fs;
use std::path::{Path, PathBuf};

use rand::rngs::SmallRng;
use rand::{RngExt, SeedableRng};

use super::journal::Step;

/// Bytes that are lost or kept as one.
const BLOCK: u64 = 4096;

/// What is lost of that which is not durable.
#[derive(Debug, Clone)]
pub(crate) enum Loss {
    /// Nothing: as if only the process had been killed.
    Nothing,
    /// Every change that is not durable.
    Everything,
    /// A random part: of this share, about.
    Some(SmallRng, f64),
}

/// A disk with files and folders. Number 0 is the folder that the journal is of.
#[derive(Debug, Default)]
pub(crate) struct Disk {
    folders: HashMap<usize, Folder>,
    files: HashMap<usize, File>,
    /// What every path leads to now, without any loss.
    paths: BTreeMap<PathBuf, usize>,
    /// The number of the next file, folder or change.
    next: usize,
}

#[derive(Debug, Default)]
struct Folder {
    changes: Vec<Change>,
    /// How many changes are durable.
    durable: usize,
}

/// A change of the names in a folder.
#[derive(Debug)]
struct Change {
    gone: Option<PathBuf>,
    new: Option<(PathBuf, usize)>,
    /// The folder and the number of the change there without which this one is not.
    after: Option<(usize, usize)>,
}

#[derive(Debug, Default)]
struct File {
    writes: Vec<Write>,
    /// How many writes are durable.
    durable: usize,
}

#[derive(Debug)]
enum Write {
    Empty,
    Bytes(u64, Vec<u8>),
}

impl Loss {
    /// A random part, which the seed alone decides.
    pub(crate) fn seeded(seed: u64) -> Loss {
        let mut random = SmallRng::seed_from_u64(seed);
        let share = [0.05, 0.3, 0.7, 0.95][random.random_range(0..4)];
        Loss::Some(random, share)
    }

    fn loses(&mut self) -> bool {
        match self {
            Loss::Nothing => false,
            Loss::Everything => true,
            Loss::Some(random, share) => random.random_bool(*share),
        }
    }

    /// How long a file is whose bytes before `durable` are durable, out of `written`.
    fn length(&mut self, durable: usize, written: usize) -> usize {
        match self {
            Loss::Some(random, share) => match random.random_bool(*share / 2.0) {
                true => random.random_range(durable.min(written)..=written),
                false => written,
            },
            Loss::Nothing | Loss::Everything => written,
        }
    }
}

impl Disk {
    /// A disk that durably holds what lies below a folder.
    pub(crate) fn of(folder: &Path) -> Disk {
        let mut disk = Disk { next: 1, ..Disk::default() };
        disk.folders.insert(0, Folder::default());
        disk.paths.insert(PathBuf::new(), 0);
        disk.hold(folder, Path::new(""));
        disk.folders.values_mut().for_each(|folder| folder.durable = folder.changes.len());
        disk.files.values_mut().for_each(|file| file.durable = file.writes.len());
        disk
    }

    fn hold(&mut self, root: &Path, below: &Path) {
        for entry in fs::read_dir(root.join(below)).unwrap().map(Result::unwrap) {
            let path = below.join(entry.file_name());
            if entry.file_type().unwrap().is_dir() {
                self.step(&Step::MakeFolder(path.clone()));
                self.hold(root, &path);
            } else {
                self.step(&Step::Create(path.clone()));
                self.step(&Step::Write(path, 0, fs::read(entry.path()).unwrap()));
            }
        }
    }

    /// Does one step.
    pub(crate) fn step(&mut self, step: &Step) {
        match step {
            Step::MakeFolder(path) | Step::Create(path) if self.paths.contains_key(path) => {}
            Step::MakeFolder(path) => {
                self.folders.insert(self.next, Folder::default());
                self.name(path, self.next, None);
                self.next += 1;
            }
            Step::Create(path) => {
                self.files.insert(self.next, File::default());
                self.name(path, self.next, None);
                self.next += 1;
            }
            Step::Write(path, at, bytes) => self.file(path).writes.push(Write::Bytes(*at, bytes.clone())),
            Step::Rewrite(path, bytes) => self.file(path).writes.extend([Write::Empty, Write::Bytes(0, bytes.clone())]),
            Step::Link(_, to) if self.paths.contains_key(to) => {}
            Step::Link(from, to) => self.name(to, self.paths[from], None),
            Step::Rename(from, to) => {
                let Some(what) = self.paths.remove(from) else { return };
                let (above, target) = (self.above(from), self.above(to));
                if above == target {
                    self.name(to, what, Some(last(from)));
                } else {
                    self.name(to, what, None);
                    let after = Some((target, self.folders[&target].changes.len() - 1));
                    self.change(above, Change { gone: Some(last(from)), new: None, after });
                }
            }
            Step::Remove(path) => {
                if self.paths.remove(path).is_some() {
                    self.change(self.above(path), Change { gone: Some(last(path)), new: None, after: None });
                }
            }
            Step::SyncFile(path) => {
                let file = self.file(path);
                file.durable = file.writes.len();
            }
            Step::SyncFolder(path) => {
                let folder = self.folders.get_mut(&self.paths[path]).unwrap();
                folder.durable = folder.changes.len();
            }
        }
    }

    fn file(&mut self, path: &Path) -> &mut File {
        self.files.get_mut(&self.paths[path]).unwrap()
    }

    fn above(&self, path: &Path) -> usize {
        self.paths[path.parent().unwrap()]
    }

    fn name(&mut self, path: &Path, what: usize, gone: Option<PathBuf>) {
        self.change(self.above(path), Change { gone, new: Some((last(path), what)), after: None });
        self.paths.insert(path.to_owned(), what);
    }

    fn change(&mut self, folder: usize, change: Change) {
        self.folders.get_mut(&folder).unwrap().changes.push(change);
    }

    /// Lays what a cut of the power leaves into an empty folder.
    pub(crate) fn cut(&self, loss: &mut Loss, to: &Path) {
        let mut numbers: Vec<usize> = self.folders.keys().copied().collect();
        numbers.sort_unstable();
        let mut kept: HashMap<usize, Vec<bool>> = HashMap::new();
        for number in &numbers {
            let Folder { changes, durable } = &self.folders[number];
            kept.insert(*number, (0..changes.len()).map(|at| at < *durable || !loss.loses()).collect());
        }
        // What must have come before a change that is durable is there too.
        for number in &numbers {
            for (at, change) in self.folders[number].changes.iter().enumerate() {
                let Some((other, before)) = change.after else { continue };
                if at < self.folders[number].durable {
                    kept.get_mut(&other).unwrap()[before] = true;
                }
                let there = kept[&other][before];
                kept.get_mut(number).unwrap()[at] &= there;
            }
        }
        let mut numbers: Vec<usize> = self.files.keys().copied().collect();
        numbers.sort_unstable();
        let bytes = numbers.into_iter().map(|number| (number, self.files[&number].after(loss))).collect();
        self.lay(0, &kept, &bytes, to);
    }

    fn lay(&self, folder: usize, kept: &HashMap<usize, Vec<bool>>, bytes: &HashMap<usize, Vec<u8>>, to: &Path) {
        let mut names = BTreeMap::new();
        for (change, _) in self.folders[&folder].changes.iter().zip(&kept[&folder]).filter(|(_, kept)| **kept) {
            if let Some(name) = &change.gone {
                names.remove(name);
            }
            names.extend(change.new.clone());
        }
        for (name, what) in names {
            let path = to.join(name);
            match bytes.get(&what) {
                Some(bytes) => fs::write(path, bytes).unwrap(),
                None => {
                    fs::create_dir(&path).unwrap();
                    self.lay(what, kept, bytes, &path);
                }
            }
        }
    }
}

impl File {
    /// The file's bytes after a cut.
    fn after(&self, loss: &mut Loss) -> Vec<u8> {
        let (mut bytes, mut durable) = (Vec::new(), 0);
        for (number, write) in self.writes.iter().enumerate() {
            let is_durable = number < self.durable;
            match write {
                Write::Empty if is_durable || !loss.loses() => bytes.clear(),
                Write::Empty => {}
                Write::Bytes(at, new) if is_durable => put(&mut bytes, *at, new),
                Write::Bytes(at, new) => blocks(*at, new).for_each(|(at, block)| {
                    if !loss.loses() {
                        put(&mut bytes, at, block);
                    }
                }),
            }
            if is_durable {
                durable = bytes.len();
            }
        }
        let end = |write: &Write| match write {
            Write::Empty => 0,
            Write::Bytes(at, new) => *at as usize + new.len(),
        };
        // The size may have reached the disk without the bytes.
        let written = self.writes[self.durable..].iter().map(end).max().unwrap_or(0);
        if let Loss::Some(..) = loss
            && written > bytes.len()
            && !loss.loses()
        {
            bytes.resize(written, 0);
        }
        let length = loss.length(durable, bytes.len());
        bytes.truncate(length);
        bytes
    }
}

/// The parts of a write that lie in one block each, and where they begin.
fn blocks(mut at: u64, mut bytes: &[u8]) -> impl Iterator<Item = (u64, &[u8])> {
    std::iter::from_fn(move || {
        let fits = ((BLOCK - at % BLOCK) as usize).min(bytes.len());
        let (block, rest) = bytes.split_at(fits);
        let found = (at, block);
        (at, bytes) = (at + fits as u64, rest);
        (!block.is_empty()).then_some(found)
    })
}

fn put(bytes: &mut Vec<u8>, at: u64, new: &[u8]) {
    let at = at as usize;
    bytes.resize(bytes.len().max(at + new.len()), 0);
    bytes[at..at + new.len()].copy_from_slice(new);
}

fn last(path: &Path) -> PathBuf {
    path.file_name().unwrap().into()
}
