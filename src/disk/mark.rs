//! The mark of a run's folder: the first file there, with an id. A folder that holds anything else and no mark belongs to
//! somebody else, and nothing in it is changed.

use std::fs;
use std::io::{ErrorKind, Write};
use std::path::Path;

use super::atomic::AtomicFile;
use super::dir::{fresh_id, make_folders};
use super::names::{Naming, TEMPORARY};
use crate::base::{Error, Result};

/// The name of the mark's file.
pub(crate) const MARK: &str = "gonio-run";

/// How the mark's file begins; the id follows.
const WORDS: &str = "The folder of a run of gonio. It removes here what it made and needs no more. Id ";

/// The file in which an older gonio kept its units.
const OLDER: &str = "manifest.json";

/// Names of other files that are shown, at most.
const SHOWN: usize = 3;

/// Whose a folder is.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Owner {
    /// The folder is empty or not there.
    Nobody,
    /// The folder is a run's.
    Run,
    /// The folder holds these and no mark.
    Other(Vec<String>),
}

/// What speaks against a run in a folder, in words; `None` if the folder is a run's, empty, or not there. Changes nothing.
///
/// # Errors
/// The folder cannot be read.
pub fn foreign(folder: &Path) -> Result<Option<String>> {
    Ok(match owner(folder)? {
        Owner::Other(names) => Some(described(&names)),
        Owner::Nobody | Owner::Run => None,
    })
}

/// Makes a folder a run's, unless it is one already.
///
/// # Errors
/// The folder holds files of others.
pub(super) fn take(folder: &Path) -> Result<()> {
    match owner(folder)? {
        Owner::Run => return Ok(()),
        Owner::Nobody => {}
        Owner::Other(names) => {
            return Err(Error::invalid(format!(
                "{} {}: it is left alone; give this run a new or empty folder, as `[run] work = \"work/NAME\"`",
                folder.display(),
                described(&names)
            )));
        }
    }
    make_folders(folder)?;
    let mut mark = AtomicFile::create(&folder.join(MARK))?;
    writeln!(mark, "{WORDS}{}", fresh_id()).map_err(Error::io("write", folder.join(MARK)))?;
    // Where another process was faster, the folder has that one's mark.
    mark.commit(Naming::FirstWins).map(drop)
}

/// The files of others in words.
fn described(names: &[String]) -> String {
    if names.iter().any(|name| name == OLDER) {
        return format!("holds {OLDER} of an older gonio, which kept its units there");
    }
    if names.iter().any(|name| name == MARK) {
        return format!("holds a {MARK} that is no mark of gonio's, or that changed since it was written");
    }
    let more = if names.len() > SHOWN { format!(" and {} more", names.len() - SHOWN) } else { String::new() };
    let shown: Vec<String> = names.iter().take(SHOWN).map(|name| name.escape_debug().to_string()).collect();
    format!("holds {}{more}, which no run of gonio made there", shown.join(", "))
}

fn owner(folder: &Path) -> Result<Owner> {
    let entries = match fs::read_dir(folder) {
        Ok(entries) => entries,
        Err(why) if why.kind() == ErrorKind::NotFound => return Ok(Owner::Nobody),
        Err(why) => return Err(Error::io("list", folder)(why)),
    };
    let mut others = Vec::new();
    for entry in entries {
        let entry = entry.map_err(Error::io("list", folder))?;
        let name = entry.file_name().to_string_lossy().into_owned();
        // A process that was killed while it made the mark left this.
        if !(name.starts_with(MARK) && name.ends_with(TEMPORARY)) {
            others.push(name);
        }
    }
    // Asked after the listing: another process may have made the mark meanwhile, and its other files come after it.
    if is_mark(&folder.join(MARK)) {
        return Ok(Owner::Run);
    }
    others.sort();
    Ok(if others.is_empty() { Owner::Nobody } else { Owner::Other(others) })
}

/// Whether a file is a mark: not a link to one, and no other file of that name.
fn is_mark(path: &Path) -> bool {
    fs::symlink_metadata(path).is_ok_and(|found| found.is_file() && found.len() < 1024)
        && fs::read(path).is_ok_and(|bytes| bytes.starts_with(WORDS.as_bytes()))
}
