//! A store that is a folder. It is opened once and held open; below it no link is followed.

use std::io::{self, ErrorKind};
use std::path::{Path, PathBuf};
use std::sync::{Arc, OnceLock};

use super::atomic::AtomicFile;
use super::folder::{Folder, Kind};
#[cfg(all(test, unix))]
use super::journal::{self, Step};
use super::mark;
use super::names::{Committed, Naming, SCRATCH, TEMPORARY, UNMARKED, check_name, fresh_id};
use super::scratch::Spool;
use super::space;
use super::store::{Content, Sink, Store};
use crate::base::{Error, Result};

/// A folder as a store.
#[derive(Debug, Clone)]
pub struct DirStore(Arc<Inner>);

#[derive(Debug)]
struct Inner {
    root: PathBuf,
    /// The folder, once it is there and was asked for.
    folder: OnceLock<Arc<Folder>>,
    attempt: OnceLock<String>,
}

impl DirStore {
    /// The store in this folder, as a new attempt; clones share the attempt. The folder is made with the first file.
    pub fn new(root: impl Into<PathBuf>) -> Self {
        DirStore(Arc::new(Inner { root: root.into(), folder: OnceLock::new(), attempt: OnceLock::new() }))
    }

    /// The folder.
    pub fn root(&self) -> &Path {
        &self.0.root
    }

    /// The folder, held open; the error's kind is `NotFound` if it is not there.
    pub(super) fn folder(&self) -> io::Result<Arc<Folder>> {
        match self.0.folder.get() {
            Some(folder) => Ok(Arc::clone(folder)),
            None => Folder::open(&self.0.root).map(|folder| Arc::clone(self.0.folder.get_or_init(|| Arc::new(folder)))),
        }
    }

    /// The folder, held open, and made if it is not there.
    pub(super) fn made_folder(&self) -> Result<Arc<Folder>> {
        make_folders(&self.0.root)?;
        self.folder().map_err(Error::io("open folder", &self.0.root))
    }

    /// Makes durable that the folder is there, and the names in it and in the folders in it. A process that was killed between
    /// a change and its sync left a change that every other process sees, and that is lost with the power.
    pub(super) fn settle(&self, folder: &Folder) -> Result<()> {
        for (name, kind) in folder.entries().map_err(Error::io("list", &self.0.root))? {
            // A folder of others may be closed to us.
            if kind == Some(Kind::Folder)
                && let Ok(below) = folder.folder(&name)
            {
                below.sync().map_err(Error::io("sync", self.path(&name)))?;
            }
        }
        folder.sync().map_err(Error::io("sync", &self.0.root))?;
        // The folder above is somebody else's, and need not be one that can be synced.
        let above = self.0.root.parent().unwrap_or(Path::new(""));
        Folder::open(above).and_then(|above| above.sync()).unwrap_or_default();
        Ok(())
    }

    /// The id of the run: that of the folder's mark. It is asked for once the folder has its mark.
    fn run(&self) -> &str {
        self.attempt().split_once('-').map_or(UNMARKED, |(run, _)| run)
    }

    /// What the temporary names of this run's files carry.
    fn own(&self) -> String {
        format!("{}-", self.run())
    }

    /// The folder of a file, and the file's name in it.
    fn locate<'a>(&self, name: &'a str) -> Result<(Arc<Folder>, &'a str)> {
        check_name(name)?;
        let (above, name) = name.rsplit_once('/').unwrap_or(("", name));
        Ok((self.below(above).map_err(Error::io("open folder", self.path(above)))?, name))
    }

    /// A folder below this one, by its path.
    fn below(&self, path: &str) -> io::Result<Arc<Folder>> {
        let parts = path.split('/').filter(|part| !part.is_empty());
        parts.into_iter().try_fold(self.folder()?, |folder, part| folder.folder(part).map(Arc::new))
    }

    /// The folder of a file, made if it is not there, and the file's name in it.
    fn make_place<'a>(&self, name: &'a str) -> Result<(Arc<Folder>, &'a str)> {
        check_name(name)?;
        let mut folder = self.made_folder()?;
        let (above, name) = name.rsplit_once('/').unwrap_or(("", name));
        for part in above.split('/').filter(|part| !part.is_empty()) {
            let failed = |why| Error::io("create folder", self.path(above))(why);
            folder = match folder.folder(part) {
                Ok(found) => Arc::new(found),
                Err(why) if why.kind() == ErrorKind::NotFound => {
                    match folder.make_folder(part) {
                        Ok(()) => folder.sync().map_err(failed)?,
                        // Another thread or process was faster.
                        Err(why) if why.kind() == ErrorKind::AlreadyExists => {}
                        Err(why) => return Err(failed(why)),
                    }
                    Arc::new(folder.folder(part).map_err(failed)?)
                }
                Err(why) => return Err(failed(why)),
            };
        }
        Ok((folder, name))
    }

    /// What is found under a name; `None` if its folder is not there.
    fn found<T>(&self, name: &str, look: impl FnOnce(&Folder, &Path) -> io::Result<Option<T>>) -> Result<Option<T>> {
        check_name(name)?;
        let (above, last) = name.rsplit_once('/').unwrap_or(("", name));
        let found = match self.below(above) {
            Ok(folder) => look(&folder, Path::new(last)),
            Err(why) if matches!(why.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => Ok(None),
            Err(why) => Err(why),
        };
        found.map_err(Error::io("look at", self.path(name)))
    }

    /// Calls `found` with the name of every file in a folder and below.
    fn walk(&self, folder: &Folder, path: &str, found: &mut dyn FnMut(String)) -> Result<()> {
        let failed = |why| Error::io("list", self.path(path))(why);
        for (name, kind) in folder.entries().map_err(failed)? {
            let name_below = if path.is_empty() { name.clone() } else { format!("{path}/{name}") };
            match kind {
                Some(Kind::File) => found(name_below),
                Some(Kind::Folder) => match folder.folder(&name) {
                    Ok(below) => self.walk(&below, &name_below, found)?,
                    Err(why) if why.kind() == ErrorKind::NotFound => {}
                    Err(why) => return Err(failed(why)),
                },
                Some(Kind::Other) | None => {}
            }
        }
        Ok(())
    }

    /// The names of all files in a folder and below for which `wanted` is true, sorted.
    fn names(&self, path: &str, wanted: impl Fn(&str) -> bool) -> Result<Vec<String>> {
        let folder = match self.below(path) {
            Ok(folder) => folder,
            // A link in a folder's place is passed over: it holds nothing of the run's.
            Err(why) if matches!(why.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => return Ok(Vec::new()),
            Err(why) => return Err(Error::io("list", self.path(path))(why)),
        };
        let mut names = Vec::new();
        self.walk(&folder, path, &mut |name| {
            if wanted(&name) {
                names.push(name);
            }
        })?;
        names.sort();
        Ok(names)
    }
}

impl Store for DirStore {
    fn begin(&self, name: &str) -> Result<Box<dyn Sink>> {
        let (folder, _) = self.make_place(name)?;
        Ok(Box::new(AtomicFile::create(folder, &self.path(name), &self.own())?))
    }

    fn spool(&self) -> Result<Box<dyn Spool>> {
        Ok(Box::new(AtomicFile::create(self.made_folder()?, &self.path(SCRATCH), &self.own())?))
    }

    fn open(&self, name: &str) -> Result<Content> {
        let (folder, last) = self.locate(name)?;
        let file = folder.open_file(last).map_err(Error::io("open", self.path(name)))?;
        // SAFETY: a committed file is never written again: it is replaced by renaming and removed by unlinking, and both
        // leave a mapped file whole. A stranger who cuts the file short while it is mapped ends the process with SIGBUS;
        // to rule that out would take a copy of tens of gigabytes.
        let map = unsafe { memmap2::Mmap::map(&file) }.map_err(Error::io("map", self.path(name)))?;
        Ok(Content::Mapped(Arc::new(map)))
    }

    fn read(&self, name: &str) -> Result<Vec<u8>> {
        let (folder, last) = self.locate(name)?;
        let mut file = folder.open_file(last).map_err(Error::io("open", self.path(name)))?;
        let mut bytes = Vec::new();
        io::Read::read_to_end(&mut file, &mut bytes).map_err(Error::io("read", self.path(name)))?;
        Ok(bytes)
    }

    fn reader(&self, name: &str) -> Result<Box<dyn io::Read>> {
        let (folder, last) = self.locate(name)?;
        Ok(Box::new(folder.open_file(last).map_err(Error::io("open", self.path(name)))?))
    }

    fn size(&self, name: &str) -> Result<Option<u64>> {
        self.found(name, |folder, last| folder.size(last))
    }

    fn is_obstructed(&self, name: &str) -> Result<bool> {
        Ok(self.found(name, |folder, last| folder.kind(last))?.is_some_and(|kind| kind != Kind::File))
    }

    fn obstacles(&self, folder: &str) -> Result<Vec<String>> {
        if !folder.is_empty() {
            check_name(folder)?;
        }
        let failed = |why| Error::io("list", self.path(folder))(why);
        let entries = match self.below(folder).and_then(|folder| folder.entries()) {
            Ok(entries) => entries,
            Err(why) if why.kind() == ErrorKind::NotFound => return Ok(Vec::new()),
            Err(why) => return Err(failed(why)),
        };
        let strange = entries.into_iter().filter(|(_, kind)| kind.is_some_and(|kind| kind != Kind::File));
        let mut names: Vec<String> =
            strange.map(|(name, _)| if folder.is_empty() { name } else { format!("{folder}/{name}") }).collect();
        names.sort();
        Ok(names)
    }

    fn list(&self, folder: &str) -> Result<Vec<String>> {
        if !folder.is_empty() {
            check_name(folder)?;
        }
        self.names(folder, |name| !name.ends_with(TEMPORARY))
    }

    fn rename(&self, from: &str, to: &str) -> Result<()> {
        let (source, last) = self.locate(from)?;
        let (target, name) = self.make_place(to)?;
        source.rename(Path::new(last), &target, Path::new(name)).map_err(Error::io("rename", self.path(from)))?;
        target.sync().map_err(Error::io("sync the folder of", self.path(to)))
    }

    fn remove(&self, name: &str) -> Result<()> {
        let (folder, last) = self.locate(name)?;
        folder.remove(Path::new(last)).map_err(Error::io("remove", self.path(name)))
    }

    fn sync(&self, folder: &str) -> Result<()> {
        if !folder.is_empty() {
            check_name(folder)?;
        }
        match self.below(folder).and_then(|folder| folder.sync()) {
            Err(why) if !matches!(why.kind(), ErrorKind::NotFound | ErrorKind::NotADirectory) => {
                Err(Error::io("sync", self.path(folder))(why))
            }
            _ => Ok(()),
        }
    }

    fn made(&self, name: &str) -> bool {
        name.contains(&format!(".{}", self.own()))
    }

    fn sweep(&self) -> Result<Vec<String>> {
        let names = self.names("", |name| name.ends_with(TEMPORARY) && self.made(name))?;
        names.iter().try_for_each(|name| {
            let (above, last) = name.rsplit_once('/').unwrap_or(("", name));
            let removed = self.below(above).and_then(|folder| folder.remove(Path::new(last)));
            removed.map_err(Error::io("remove", self.path(name)))
        })?;
        Ok(names)
    }

    fn free(&self) -> Option<u64> {
        space::free(&self.0.root)
    }

    fn path(&self, name: &str) -> PathBuf {
        self.0.root.join(name)
    }

    fn attempt(&self) -> &str {
        self.0.attempt.get_or_init(|| {
            let run = self.folder().ok().and_then(|folder| mark::id(&folder));
            format!("{}-{}", run.as_deref().unwrap_or(UNMARKED), fresh_id())
        })
    }
}

impl Sink for AtomicFile {
    fn commit(self: Box<Self>, naming: Naming) -> Result<Committed> {
        AtomicFile::commit(*self, naming)
    }
}

/// Makes a folder and those above it, durably. Links in the path are followed: its owner set them.
fn make_folders(path: &Path) -> Result<()> {
    if path.is_dir() || path == Path::new("") {
        return Ok(());
    }
    let above = path.parent().unwrap_or(Path::new(""));
    make_folders(above)?;
    match create_folder(path) {
        Ok(()) => Folder::open(above).and_then(|above| above.sync()).map_err(Error::io("sync the folder of", path)),
        // Another thread or process was faster.
        Err(_) if path.is_dir() => Ok(()),
        Err(why) => Err(Error::io("create folder", path)(why)),
    }
}

fn create_folder(path: &Path) -> io::Result<()> {
    #[cfg(all(test, unix))]
    let _noted = journal::note_at(path, || Step::MakeFolder(path.to_owned()))?;
    std::fs::create_dir(path)
}
