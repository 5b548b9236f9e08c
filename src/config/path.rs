//! Paths: what must stand at the end of one.

use std::borrow::Cow;
use std::fs;
use std::io::ErrorKind;
use std::path::{Path, PathBuf};

use super::problem::Problem;
use crate::base::pattern;

/// What a path must lead to.
#[derive(Debug, Clone)]
pub struct Leads {
    to: To,
    /// The advice where the path leads to nothing.
    missing: Cow<'static, str>,
}

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum To {
    File,
    Files,
    Folder,
    FileOrFolder,
    FolderOrNothing,
}

impl Leads {
    /// To a file; `missing` says what to do where there is none.
    pub fn to_file(missing: impl Into<Cow<'static, str>>) -> Self {
        Leads { to: To::File, missing: missing.into() }
    }

    /// To a file, or to several where `*` stands in the path; `missing` says what to do where there is none.
    pub fn to_files(missing: impl Into<Cow<'static, str>>) -> Self {
        Leads { to: To::Files, missing: missing.into() }
    }

    /// To a folder; `missing` says what to do where there is none.
    pub fn to_folder(missing: impl Into<Cow<'static, str>>) -> Self {
        Leads { to: To::Folder, missing: missing.into() }
    }

    /// To a file or a folder; `missing` says what to do where there is neither.
    pub fn to_file_or_folder(missing: impl Into<Cow<'static, str>>) -> Self {
        Leads { to: To::FileOrFolder, missing: missing.into() }
    }

    /// To a folder, or to nothing yet; `missing` says what to do where something else is there.
    pub fn to_folder_or_nothing(missing: impl Into<Cow<'static, str>>) -> Self {
        Leads { to: To::FolderOrNothing, missing: missing.into() }
    }

    /// The path, if it leads where it must. Where the run makes it (`made`), nothing need be there yet.
    pub(super) fn check(&self, path: PathBuf, made: bool) -> Result<PathBuf, Problem> {
        let wrong = |rule: &str| {
            let shown = path.display().to_string();
            Problem::new(rule).got(shown.escape_debug().to_string()).hint(self.missing.clone())
        };
        if self.to == To::Files && pattern::is_pattern(&path) && !made {
            return match pattern::files(&path) {
                Ok(files) if files.is_empty() => Err(wrong("no file fits, where * stands for any part of a name")),
                Ok(_) => Ok(path),
                Err(why) => Err(wrong(&format!("cannot be listed: {why}"))),
            };
        }
        match (fs::metadata(&path), self.to) {
            (Ok(there), To::File | To::Files) if there.is_dir() => Err(wrong("must be a file, and is a folder")),
            (Ok(there), To::Folder | To::FolderOrNothing) if !there.is_dir() => {
                Err(wrong("must be a folder, and is a file"))
            }
            (Ok(_), _) => Ok(path),
            (Err(why), to) if why.kind() == ErrorKind::NotFound => match to {
                _ if made => Ok(path),
                To::FolderOrNothing => Ok(path),
                To::File | To::Files => Err(wrong("no such file")),
                To::Folder => Err(wrong("no such folder")),
                To::FileOrFolder => Err(wrong("no such file or folder")),
            },
            (Err(why), _) => Err(wrong(&format!("cannot be read: {why}"))),
        }
    }
}

/// A path without links, `.` and `..`, as far as it leads somewhere.
pub(crate) fn real(path: &Path) -> PathBuf {
    let whole = std::path::absolute(path).unwrap_or_else(|_| path.to_path_buf());
    let found = whole.ancestors().find_map(|above| Some((above, above.canonicalize().ok()?)));
    found.map_or_else(
        || whole.clone(),
        |(above, real)| whole.strip_prefix(above).map_or_else(|_| real.clone(), |rest| real.join(rest)),
    )
}
