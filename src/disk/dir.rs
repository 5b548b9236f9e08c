//! A store that is a folder.

use std::fs::{self, File};
use std::hash::{BuildHasher, RandomState};
use std::io;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use super::atomic::{AtomicFile, sync_folder, sync_folder_of};
use super::names::{Committed, Naming, SCRATCH, TEMPORARY, check_name};
use super::scratch::Spool;
use super::space;
use super::store::{Content, Sink, Store};
use crate::base::{Error, Result};

/// A folder as a store. Links to other folders are not followed when it is listed or swept.
#[derive(Debug, Clone)]
pub struct DirStore {
    root: PathBuf,
    attempt: Arc<str>,
}

impl DirStore {
    /// The store in this folder, as a new attempt; clones share the attempt. The folder is made with the first file.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        DirStore { root: root.into(), attempt: fresh_id().into() }
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.root
    }

    fn locate(&self, name: &str) -> Result<PathBuf> {
        check_name(name)?;
        Ok(self.root.join(name))
    }

    /// What has this name, a link itself.
    fn found(&self, name: &str) -> Result<Option<fs::Metadata>> {
        let path = self.locate(name)?;
        match fs::symlink_metadata(&path) {
            Ok(found) => Ok(Some(found)),
            Err(why) if matches!(why.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(None),
            Err(why) => Err(Error::io("look at", &path)(why)),
        }
    }

    /// Calls `found` with the name of every file in a folder and below.
    fn walk(&self, folder: &str, found: &mut dyn FnMut(String)) -> Result<()> {
        for (name, kind) in entries(&self.root.join(folder))? {
            let name = if folder.is_empty() { name } else { format!("{folder}/{name}") };
            if kind.is_dir() {
                self.walk(&name, found)?;
            } else if kind.is_file() {
                found(name);
            }
        }
        Ok(())
    }
}

impl Store for DirStore {
    fn begin(&self, name: &str) -> Result<Box<dyn Sink>> {
        let path = self.locate(name)?;
        if let Some(parent) = path.parent() {
            make_folders(parent)?;
        }
        Ok(Box::new(AtomicFile::create(&path)?))
    }

    fn spool(&self) -> Result<Box<dyn Spool>> {
        make_folders(&self.root)?;
        Ok(Box::new(AtomicFile::create(&self.root.join(SCRATCH))?))
    }

    fn open(&self, name: &str) -> Result<Content> {
        let path = self.locate(name)?;
        let file = File::open(&path).map_err(Error::io("open", &path))?;
        // SAFETY: a committed file is never written again: it is replaced by renaming and removed by unlinking, and both
        // leave a mapped file whole. A stranger who cuts the file short while it is mapped ends the process with SIGBUS;
        // to rule that out would take a copy of tens of gigabytes.
        let map = unsafe { memmap2::Mmap::map(&file) }.map_err(Error::io("map", &path))?;
        Ok(Content::Mapped(Arc::new(map)))
    }

    fn read(&self, name: &str) -> Result<Vec<u8>> {
        let path = self.locate(name)?;
        fs::read(&path).map_err(Error::io("read", &path))
    }

    fn reader(&self, name: &str) -> Result<Box<dyn io::Read>> {
        let path = self.locate(name)?;
        Ok(Box::new(File::open(&path).map_err(Error::io("open", &path))?))
    }

    fn size(&self, name: &str) -> Result<Option<u64>> {
        Ok(self.found(name)?.filter(fs::Metadata::is_file).map(|found| found.len()))
    }

    fn is_obstructed(&self, name: &str) -> Result<bool> {
        Ok(self.found(name)?.is_some_and(|found| !found.is_file()))
    }

    fn obstacles(&self, folder: &str) -> Result<Vec<String>> {
        let path = if folder.is_empty() { self.root.clone() } else { self.locate(folder)? };
        let mut names = Vec::new();
        for (name, kind) in entries(&path)? {
            if !kind.is_file() {
                names.push(if folder.is_empty() { name } else { format!("{folder}/{name}") });
            }
        }
        names.sort();
        Ok(names)
    }

    fn list(&self, folder: &str) -> Result<Vec<String>> {
        if !folder.is_empty() {
            check_name(folder)?;
        }
        let mut names = Vec::new();
        self.walk(folder, &mut |name| {
            if !name.ends_with(TEMPORARY) {
                names.push(name);
            }
        })?;
        names.sort();
        Ok(names)
    }

    fn rename(&self, from: &str, to: &str) -> Result<()> {
        let (from, to) = (self.locate(from)?, self.locate(to)?);
        if let Some(parent) = to.parent() {
            make_folders(parent)?;
        }
        fs::rename(&from, &to).map_err(Error::io("rename", &from))?;
        sync_folder_of(&to)
    }

    fn remove(&self, name: &str) -> Result<()> {
        let path = self.locate(name)?;
        fs::remove_file(&path).map_err(Error::io("remove", &path))
    }

    fn sync(&self, folder: &str) -> Result<()> {
        let path = if folder.is_empty() { self.root.clone() } else { self.locate(folder)? };
        if path.is_dir() { sync_folder(&path) } else { Ok(()) }
    }

    fn sweep(&self) -> Result<Vec<String>> {
        let mut names = Vec::new();
        self.walk("", &mut |name| {
            if name.ends_with(TEMPORARY) {
                names.push(name);
            }
        })?;
        names.sort();
        for name in &names {
            let path = self.root.join(name);
            fs::remove_file(&path).map_err(Error::io("remove", &path))?;
        }
        Ok(names)
    }

    fn free(&self) -> Option<u64> {
        space::free(&self.root)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.root.join(name)
    }

    fn attempt(&self) -> &str {
        &self.attempt
    }
}

impl Sink for AtomicFile {
    fn commit(self: Box<Self>, naming: Naming) -> Result<Committed> {
        AtomicFile::commit(*self, naming)
    }
}

/// The names in a folder, which may not be there, and what each stands for.
fn entries(path: &Path) -> Result<Vec<(String, fs::FileType)>> {
    let entries = match fs::read_dir(path) {
        Ok(entries) => entries,
        Err(why) if why.kind() == io::ErrorKind::NotFound => return Ok(Vec::new()),
        Err(why) => return Err(Error::io("list", path)(why)),
    };
    let mut found = Vec::new();
    for entry in entries {
        let entry = entry.map_err(Error::io("list", path))?;
        // gonio gives no file a name that is not UTF-8.
        let Ok(name) = entry.file_name().into_string() else { continue };
        found.push((name, entry.file_type().map_err(Error::io("list", entry.path()))?));
    }
    Ok(found)
}

/// Makes a folder and those above it, durably.
pub(super) fn make_folders(folder: &Path) -> Result<()> {
    if folder.is_dir() || folder == Path::new("") {
        return Ok(());
    }
    if let Some(above) = folder.parent() {
        make_folders(above)?;
    }
    match fs::create_dir(folder) {
        Ok(()) => sync_folder_of(folder),
        // Another thread or process was faster.
        Err(_) if folder.is_dir() => Ok(()),
        Err(why) => Err(Error::io("create folder", folder)(why)),
    }
}

/// An id that nobody else has: 16 hexadecimal digits from the system's random numbers.
pub(super) fn fresh_id() -> String {
    format!("{:016x}", RandomState::new().hash_one(0))
}
