//! The photographs that poses are of, as far as a format has to look at them: some files name photographs by a path of
//! another machine or by their place in a list, and some do not say how large they are.

use std::cell::OnceCell;
use std::fs;
use std::path::{Path, PathBuf};

use crate::base::{Error, Result};
use crate::codec::images::{self, Size, is_picture};

/// The door to the photographs of a scene.
pub trait Photographs {
    /// The names of all photographs: paths below the image folder, with `/` between folders, sorted.
    ///
    /// # Errors
    /// A folder that cannot be read.
    fn names(&self) -> Result<&[String]>;

    /// The size of a photograph, by its header. One that is not there, or whose header is broken, has that of the first whose header is
    /// whole: it is told of and skipped when it is read, and so are pixels of another size than was said.
    ///
    /// # Errors
    /// A photograph whose header cannot be read, where no other's can.
    fn size(&self, name: &str) -> Result<Size>;
}

/// The most photographs of a folder, and the most folders above one another: a link may lead round.
const MOST: usize = 1_000_000;
const DEEPEST: usize = 16;

/// The photographs in a folder and the folders below.
#[derive(Debug)]
pub struct PhotographFolder {
    path: PathBuf,
    names: OnceCell<Vec<String>>,
    /// The size of the first photograph that has one.
    usual: OnceCell<Option<Size>>,
}

impl PhotographFolder {
    /// The photographs in a folder, which is looked at when a format asks.
    pub fn new(path: &Path) -> Self {
        PhotographFolder { path: path.to_owned(), names: OnceCell::new(), usual: OnceCell::new() }
    }
}

impl Photographs for PhotographFolder {
    fn names(&self) -> Result<&[String]> {
        if let Some(names) = self.names.get() {
            return Ok(names);
        }
        let mut found = Vec::new();
        // A scene may be posed before its photographs are there.
        if self.path.is_dir() {
            add(&self.path, "", DEEPEST, &mut found)?;
        }
        found.sort();
        Ok(self.names.get_or_init(|| found))
    }

    fn size(&self, name: &str) -> Result<Size> {
        let size = images::size(&self.path.join(name));
        size.or_else(|why| self.usual()?.ok_or(why))
            .map_err(|why| why.doing("read an image's size, which the poses do not say"))
    }
}

impl PhotographFolder {
    /// The size of the first photograph that has one.
    fn usual(&self) -> Result<Option<Size>> {
        if let Some(usual) = self.usual.get() {
            return Ok(*usual);
        }
        let found = self.names()?.iter().find_map(|name| images::size(&self.path.join(name)).ok());
        Ok(*self.usual.get_or_init(|| found))
    }
}

/// Adds the pictures of a folder, whose name below the image folder is `prefix`.
fn add(folder: &Path, prefix: &str, depth: usize, found: &mut Vec<String>) -> Result<()> {
    for entry in fs::read_dir(folder).map_err(Error::io("read", folder))? {
        let path = entry.map_err(Error::io("read", folder))?.path();
        let Some(name) = path.file_name().and_then(|name| name.to_str()) else { continue };
        if found.len() >= MOST {
            return Err(Error::malformed(folder, format!("more than {MOST} photographs lie here and below")));
        }
        if path.is_dir() {
            if depth > 0 {
                add(&path, &format!("{prefix}{name}/"), depth - 1, found)?;
            }
        } else if is_picture(&path) {
            found.push(format!("{prefix}{name}"));
        }
    }
    Ok(())
}

/// No photographs: poses alone are looked at.
#[derive(Debug, Clone, Copy)]
pub struct NoPhotographs;

impl Photographs for NoPhotographs {
    fn names(&self) -> Result<&[String]> {
        Ok(&[])
    }

    fn size(&self, name: &str) -> Result<Size> {
        let advice = "name the folder of the photographs";
        Err(Error::invalid(format!(
            "the size of {name} is not in the poses and has to be read from the image: {advice}"
        )))
    }
}

/// Photographs that are nowhere but in a test.
#[cfg(test)]
pub(crate) struct Listed {
    /// The names of all.
    pub names: Vec<String>,
    /// The size of each.
    pub size: Size,
}

#[cfg(test)]
impl Photographs for Listed {
    fn names(&self) -> Result<&[String]> {
        Ok(&self.names)
    }

    fn size(&self, _: &str) -> Result<Size> {
        Ok(self.size)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pictures_are_found_with_their_folders() {
        let dir = tempfile::tempdir().unwrap();
        fs::create_dir_all(dir.path().join("b/c")).unwrap();
        for name in ["z.JPG", "b/a.png", "b/c/x.tif", "notes.txt"] {
            fs::write(dir.path().join(name), "").unwrap();
        }
        let folder = PhotographFolder::new(dir.path());
        assert_eq!(folder.names().unwrap(), ["b/a.png", "b/c/x.tif", "z.JPG"]);
        assert!(folder.size("z.JPG").is_err());
        assert!(PhotographFolder::new(&dir.path().join("nowhere")).names().unwrap().is_empty());
        let why = NoPhotographs.size("a.jpg").unwrap_err().to_string();
        assert!(why.contains("a.jpg") && why.contains("name the folder"), "{why}");
    }

    #[test]
    fn a_photograph_that_is_not_there_has_the_size_of_those_that_are() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("a.png"), "no picture").unwrap();
        let of = |name: &str| PhotographFolder::new(dir.path()).size(name);
        for name in ["a.png", "gone.png"] {
            let why = of(name).unwrap_err().to_string();
            assert!(why.contains("which the poses do not say") && why.contains(name), "{why}");
        }
        image::RgbImage::new(8, 6).save(dir.path().join("b.png")).unwrap();
        for name in ["a.png", "b.png", "gone.png"] {
            assert_eq!(of(name).unwrap(), Size { width: 8, height: 6 }, "{name}");
        }
    }

    #[cfg(unix)]
    #[test]
    fn a_link_that_leads_round_ends() {
        let dir = tempfile::tempdir().unwrap();
        fs::write(dir.path().join("a.jpg"), "").unwrap();
        std::os::unix::fs::symlink(dir.path(), dir.path().join("round")).unwrap();
        assert_eq!(PhotographFolder::new(dir.path()).names().unwrap().len(), DEEPEST + 1);
    }
}
