//! One file being read: its tree, its folder, and the problems found so far.

use std::cell::RefCell;
use std::ffi::OsStr;
use std::path::{Path, PathBuf};

use super::faults::Faults;
use super::path::real;
use super::problem::{Position, Problem};
use super::raw::Table;

/// A file being read. Reading collects problems and goes on.
#[derive(Debug)]
pub struct Document<'a> {
    /// The file's tree.
    pub root: &'a Table,
    /// The file's folder, to which its paths are relative.
    pub folder: &'a Path,
    /// The file's name without its ending.
    pub stem: &'a OsStr,
    faults: RefCell<Faults>,
    made: RefCell<Vec<(&'static str, PathBuf)>>,
    work: RefCell<Option<PathBuf>>,
}

impl<'a> Document<'a> {
    /// The document of a file, in which these problems were found already.
    pub fn new(root: &'a Table, file: &'a Path, faults: Faults) -> Self {
        let (folder, stem) = (file.parent().unwrap_or(Path::new("")), file.file_stem().unwrap_or_default());
        Document {
            root,
            folder,
            stem,
            faults: RefCell::new(faults),
            made: RefCell::default(),
            work: RefCell::default(),
        }
    }

    /// Adds a problem.
    pub fn add(&self, problem: Problem) {
        self.faults.borrow_mut().add(problem);
    }

    /// Adds a problem for each of these. `words` is asked only for those that may be told.
    pub fn add_many<T>(&self, all: Vec<(&Position, T)>, words: impl Fn((&Position, T)) -> Problem) {
        self.faults.borrow_mut().add_many(all, words);
    }

    /// Declares a path that the run makes itself: where the key `field` leads to it, nothing need be there yet.
    pub fn makes(&self, field: &'static str, path: PathBuf) {
        self.made.borrow_mut().push((field, path));
    }

    /// Whether the run itself makes the path that the key `field` leads to.
    pub fn is_made(&self, field: &str, path: &Path) -> bool {
        self.made.borrow().iter().any(|(key, made)| *key == field && made == path)
    }

    /// Declares the folder that the run writes to: no input may lie in it.
    pub fn works_in(&self, folder: &Path) {
        *self.work.borrow_mut() = Some(real(folder));
    }

    /// Whether a path lies in the folder that the run writes to.
    pub fn is_in_work(&self, path: &Path) -> bool {
        self.work.borrow().as_ref().is_some_and(|work| real(path).starts_with(work))
    }

    /// The problems that were found.
    pub fn into_faults(self) -> Faults {
        self.faults.into_inner()
    }
}
