//! Folders by paths, for systems without descriptors of folders: links are looked for before a name is used.

use std::fs::{self, File, OpenOptions};
use std::io;
use std::path::{Path, PathBuf};

use super::kind::{Kind, regular, strange};

/// A folder by its path.
#[derive(Debug)]
pub(in crate::disk) struct Folder(PathBuf);

impl Folder {
    /// A folder by its path. Links in the path are followed: its owner set them.
    pub(in crate::disk) fn open(path: &Path) -> io::Result<Folder> {
        let path = if path == Path::new("") { Path::new(".") } else { path };
        if !fs::metadata(path)?.is_dir() {
            return Err(io::ErrorKind::NotADirectory.into());
        }
        Ok(Folder(path.to_owned()))
    }

    /// A folder in this one.
    pub(in crate::disk) fn folder(&self, name: &str) -> io::Result<Folder> {
        match self.kind(Path::new(name))? {
            Some(Kind::Folder) => Ok(Folder(self.0.join(name))),
            Some(_) => Err(io::ErrorKind::NotADirectory.into()),
            None => Err(io::ErrorKind::NotFound.into()),
        }
    }

    /// Makes a folder in this one.
    pub(in crate::disk) fn make_folder(&self, name: &str) -> io::Result<()> {
        fs::create_dir(self.0.join(name))
    }

    /// Opens a file to be read.
    pub(in crate::disk) fn open_file(&self, name: &str) -> io::Result<File> {
        self.file(name, OpenOptions::new().read(true))
    }

    /// Opens a file to be read and written; it is made if there is none.
    pub(in crate::disk) fn open_or_create(&self, name: &str) -> io::Result<File> {
        self.file(name, OpenOptions::new().read(true).write(true).create(true).truncate(false))
    }

    /// Makes a file, to be read and written. The error's kind is `AlreadyExists` if anything has the name.
    pub(in crate::disk) fn create_new(&self, name: &Path) -> io::Result<File> {
        OpenOptions::new().read(true).write(true).create_new(true).open(self.0.join(name))
    }

    fn file(&self, name: &str, options: &OpenOptions) -> io::Result<File> {
        match self.kind(Path::new(name))? {
            None | Some(Kind::File) => regular(options.open(self.0.join(name))?),
            Some(_) => Err(strange()),
        }
    }

    /// What a name stands for; `None` if there is nothing.
    pub(in crate::disk) fn kind(&self, name: &Path) -> io::Result<Option<Kind>> {
        match fs::symlink_metadata(self.0.join(name)) {
            Ok(found) if found.is_file() => Ok(Some(Kind::File)),
            Ok(found) if found.is_dir() => Ok(Some(Kind::Folder)),
            Ok(_) => Ok(Some(Kind::Other)),
            Err(why) if matches!(why.kind(), io::ErrorKind::NotFound | io::ErrorKind::NotADirectory) => Ok(None),
            Err(why) => Err(why),
        }
    }

    /// The size in bytes of a file; `None` if no file has the name.
    pub(in crate::disk) fn size(&self, name: &Path) -> io::Result<Option<u64>> {
        match self.kind(name)? {
            Some(Kind::File) => fs::symlink_metadata(self.0.join(name)).map(|found| Some(found.len())),
            _ => Ok(None),
        }
    }

    /// Whether a name stands for this open file: nobody says here.
    pub(in crate::disk) fn is_named(&self, _: &File, _: &Path) -> bool {
        false
    }

    /// The names in the folder, and what each stands for.
    pub(in crate::disk) fn entries(&self) -> io::Result<Vec<(String, Option<Kind>)>> {
        let mut found = Vec::new();
        for entry in fs::read_dir(&self.0)? {
            let name = entry?.file_name();
            let kind = self.kind(Path::new(&name))?;
            found.push((name.to_string_lossy().into_owned(), kind));
        }
        Ok(found)
    }

    /// Gives a file another name, in another folder, in place of the file that has it.
    pub(in crate::disk) fn rename(&self, from: &Path, to: &Folder, name: &Path) -> io::Result<()> {
        fs::rename(self.0.join(from), to.0.join(name))
    }

    /// Gives a file a second name in this folder. The error's kind is `AlreadyExists` if anything has that name.
    pub(in crate::disk) fn link(&self, from: &Path, to: &Path) -> io::Result<()> {
        fs::hard_link(self.0.join(from), self.0.join(to))
    }

    /// Renames a file unless the name is taken: not to be had here.
    pub(in crate::disk) fn rename_new(&self, _: &Path, _: &Path) -> io::Result<()> {
        Err(io::Error::new(io::ErrorKind::Unsupported, "this filesystem has no hard links: use another one"))
    }

    /// Removes a file, or a link itself.
    pub(in crate::disk) fn remove(&self, name: &Path) -> io::Result<()> {
        fs::remove_file(self.0.join(name))
    }

    /// Makes the names in the folder durable.
    pub(in crate::disk) fn sync(&self) -> io::Result<()> {
        File::open(&self.0)?.sync_all()
    }
}

/// Whether this is how a filesystem says that it has no hard links.
pub(in crate::disk) fn has_no_links(why: &io::Error) -> bool {
    why.kind() == io::ErrorKind::Unsupported
}
