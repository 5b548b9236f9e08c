//! One path or several that lead to one thing, as to a mesh of parts.

use std::collections::BTreeSet;
use std::fmt;
use std::path::{Path, PathBuf};

use super::pattern;
use super::{Error, Result};

/// One path or more. In each, `*` stands for any part of a name.
#[derive(Clone, PartialEq, Eq)]
pub struct Paths {
    first: PathBuf,
    others: Vec<PathBuf>,
}

impl Paths {
    /// These paths; `None` of none.
    pub(crate) fn new(paths: Vec<PathBuf>) -> Option<Paths> {
        let mut paths = paths.into_iter();
        paths.next().map(|first| Paths { first, others: paths.collect() })
    }

    /// The first path.
    pub(crate) fn first(&self) -> &Path {
        &self.first
    }

    /// The files that the paths lead to, in their order; those of one path sorted by name.
    ///
    /// # Errors
    /// A folder that cannot be listed; a path that no file fits; a file that two paths lead to.
    pub(crate) fn files(&self) -> Result<Vec<PathBuf>> {
        let mut all = Vec::new();
        for path in [&self.first].into_iter().chain(&self.others) {
            let files = pattern::files(path).map_err(Error::io("list", path))?;
            if files.is_empty() {
                return Err(Error::invalid(format!("{}: no file fits, where * is any part of a name", path.display())));
            }
            all.extend(files);
        }
        let mut known = BTreeSet::new();
        match all.iter().find(|file| !known.insert(*file)) {
            Some(twice) => {
                Err(Error::invalid(format!("{self} lead to {} twice: each file must come once", twice.display())))
            }
            None => Ok(all),
        }
    }
}

impl<P: Into<PathBuf>> From<P> for Paths {
    fn from(path: P) -> Paths {
        Paths { first: path.into(), others: Vec::new() }
    }
}

impl fmt::Display for Paths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.first.display())?;
        self.others.iter().try_for_each(|other| write!(f, ", {}", other.display()))
    }
}

/// As a pipeline file has it: a path, or a list.
impl fmt::Debug for Paths {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match &self.others[..] {
            [] => self.first.fmt(f),
            others => f.debug_list().entry(&self.first).entries(others).finish(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_keep_the_order_of_the_paths_and_come_once() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        for name in ["b.obj", "a.obj", "c.ply"] {
            std::fs::write(at(name), "").unwrap();
        }
        let files = |names: &[&str]| Paths::new(names.iter().map(|name| at(name)).collect()).unwrap().files();
        assert_eq!(files(&["c.ply", "*.obj"]).unwrap(), ["c.ply", "a.obj", "b.obj"].map(at));
        assert!(files(&["b.obj", "*.obj"]).unwrap_err().to_string().contains("b.obj twice"));
        assert!(files(&["c.ply", "*.stl"]).unwrap_err().to_string().contains("*.stl: no file fits"));
        assert_eq!(Paths::new(Vec::new()), None);
        let (one, two) = (Paths::from("a"), Paths::new(vec!["a".into(), "b".into()]).unwrap());
        assert_eq!([format!("{one} {one:?}"), format!("{two} {two:?}")], ["a \"a\"", "a, b [\"a\", \"b\"]"]);
    }
}
