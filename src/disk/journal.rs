//! Journals of what is done to folders, for tests: every change below a folder in its order, and the end of the process at
//! one of them. Tests run side by side, so a journal belongs to a folder and to nobody else's files.
//!
//! A change is noted before it is made, and nobody makes another one meanwhile. A sync is noted and not done: what would be lost
//! without it is made up from the journal, and no test waits for the disk.

use std::fs;
use std::io;
use std::os::fd::{AsFd, AsRawFd};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

/// A change below a folder, or a sync.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) enum Step {
    /// A folder is made.
    MakeFolder(PathBuf),
    /// A file is made, unless it is there.
    Create(PathBuf),
    /// Bytes are written at a place of a file.
    Write(PathBuf, u64, Vec<u8>),
    /// A file is emptied and written anew, in place.
    Rewrite(PathBuf, Vec<u8>),
    /// A file gets a second name, unless that is taken.
    Link(PathBuf, PathBuf),
    /// A file gets another name.
    Rename(PathBuf, PathBuf),
    /// A name goes.
    Remove(PathBuf),
    /// A file's bytes become durable.
    SyncFile(PathBuf),
    /// The names in a folder become durable.
    SyncFolder(PathBuf),
}

/// The journal of a folder, kept as long as this lives.
#[derive(Debug)]
pub(crate) struct Journal(PathBuf);

/// Lets nobody else make a change, as long as it lives.
pub(crate) type Noted = MutexGuard<'static, Vec<Book>>;

#[derive(Debug)]
pub(crate) struct Book {
    folder: PathBuf,
    steps: Vec<Step>,
    /// The number of steps after which the process is gone.
    ends: usize,
}

static BOOKS: Mutex<Vec<Book>> = Mutex::new(Vec::new());

fn books() -> Noted {
    BOOKS.lock().unwrap_or_else(PoisonError::into_inner)
}

impl Journal {
    /// Begins the journal of a folder that is there.
    pub(crate) fn of(folder: &Path) -> Journal {
        let folder = fs::canonicalize(folder).unwrap_or_else(|_| folder.to_owned());
        books().push(Book { folder: folder.clone(), steps: Vec::new(), ends: usize::MAX });
        Journal(folder)
    }

    /// Ends the process after this number of steps: nothing that it does from then on is done.
    pub(crate) fn ends_after(&self, steps: usize) {
        books().iter_mut().filter(|book| book.folder == self.0).for_each(|book| book.ends = steps);
    }

    /// All steps so far, with paths relative to the folder.
    pub(crate) fn steps(&self) -> Vec<Step> {
        books().iter().find(|book| book.folder == self.0).map(|book| book.steps.clone()).unwrap_or_default()
    }
}

impl Drop for Journal {
    fn drop(&mut self) {
        books().retain(|book| book.folder != self.0);
    }
}

/// Notes a step in a folder that is held open, where a journal is kept of it. An error if the process is gone.
pub(super) fn note(folder: &impl AsFd, step: impl FnOnce(&Path) -> Step) -> io::Result<Option<Noted>> {
    if books().is_empty() {
        return Ok(None);
    }
    let Some(path) = path_of(folder) else { return Ok(None) };
    note_at(&path, || step(&path))
}

/// Notes a step from one folder to another.
pub(super) fn note_between(
    from: &impl AsFd,
    to: &impl AsFd,
    step: impl FnOnce(&Path, &Path) -> Step,
) -> io::Result<Option<Noted>> {
    match path_of(to) {
        Some(to) => note(from, |from| step(from, &to)),
        None => Ok(None),
    }
}

/// Notes a step at a path.
pub(super) fn note_at(path: &Path, step: impl FnOnce() -> Step) -> io::Result<Option<Noted>> {
    let mut books = books();
    let Some(book) = books.iter_mut().find(|book| path.starts_with(&book.folder)) else { return Ok(None) };
    if book.steps.len() >= book.ends {
        return Err(io::Error::other("the process is gone"));
    }
    let step = step().below(&book.folder);
    book.steps.push(step);
    Ok(Some(books))
}

/// The path of an open folder, where the system says (Linux).
fn path_of(folder: &impl AsFd) -> Option<PathBuf> {
    fs::read_link(format!("/proc/self/fd/{}", folder.as_fd().as_raw_fd())).ok()
}

impl Step {
    /// The step with paths relative to a folder.
    fn below(self, folder: &Path) -> Step {
        let cut = |path: PathBuf| path.strip_prefix(folder).map(Path::to_owned).unwrap_or(path);
        match self {
            Step::MakeFolder(path) => Step::MakeFolder(cut(path)),
            Step::Create(path) => Step::Create(cut(path)),
            Step::Write(path, at, bytes) => Step::Write(cut(path), at, bytes),
            Step::Rewrite(path, bytes) => Step::Rewrite(cut(path), bytes),
            Step::Link(from, to) => Step::Link(cut(from), cut(to)),
            Step::Rename(from, to) => Step::Rename(cut(from), cut(to)),
            Step::Remove(path) => Step::Remove(cut(path)),
            Step::SyncFile(path) => Step::SyncFile(cut(path)),
            Step::SyncFolder(path) => Step::SyncFolder(cut(path)),
        }
    }
}
