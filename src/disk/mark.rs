//! The mark of a run's folder: the first file there, with an id. A folder that holds anything else and no mark belongs to
//! somebody else, and nothing in it is changed. The id is a part of the names of the run's files.

use std::io::{ErrorKind, Read, Write};
use std::path::Path;
use std::sync::Arc;

use super::atomic::AtomicFile;
use super::folder::Folder;
use super::names::{Naming, TEMPORARY, fresh_id};
use crate::base::{Error, Result};

/// The name of the mark's file.
pub(crate) const MARK: &str = "gonio-run";

/// How the mark's file begins; the id follows.
const WORDS: &str = "The folder of a run of gonio. It removes here what it made and needs no more. Id ";

/// The digits of an id.
const DIGITS: usize = 16;

/// The file in which an older gonio kept its units.
const OLDER: &str = "manifest.json";

/// Names of other files that are shown, at most.
const SHOWN: usize = 3;

/// Whose a folder is.
#[derive(Debug, Clone, PartialEq, Eq)]
enum Owner {
    /// The folder is empty.
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
    if folder == Path::new("") {
        // No folder was named, which is told elsewhere.
        return Ok(None);
    }
    let owner = match Folder::open(folder) {
        Ok(opened) => owner(&opened).map_err(Error::io("list", folder))?,
        Err(why) if why.kind() == ErrorKind::NotFound => Owner::Nobody,
        Err(why) => return Err(Error::io("open folder", folder)(why)),
    };
    Ok(match owner {
        Owner::Other(names) => Some(described(&names)),
        Owner::Nobody | Owner::Run => None,
    })
}

/// Makes a folder, which is at `path`, a run's, unless it is one already.
///
/// # Errors
/// The folder holds files of others.
pub(super) fn take(folder: &Arc<Folder>, path: &Path) -> Result<()> {
    match owner(folder).map_err(Error::io("list", path))? {
        Owner::Run => return Ok(()),
        Owner::Nobody => {}
        Owner::Other(names) => {
            return Err(Error::invalid(format!(
                "{} {}: it is left alone; give this run a new or empty folder, as `[run] work = \"work/NAME\"`",
                path.display(),
                described(&names)
            )));
        }
    }
    let mut mark = AtomicFile::create(Arc::clone(folder), &path.join(MARK), "")?;
    writeln!(mark, "{WORDS}{}", fresh_id()).map_err(Error::io("write", path.join(MARK)))?;
    // Where another process was faster, the folder has that one's mark.
    mark.commit(Naming::FirstWins).map(drop)
}

/// The id of the run whose folder this is; `None` if it is no run's.
pub(super) fn id(folder: &Folder) -> Option<String> {
    let mut text = String::new();
    let most = WORDS.len() + DIGITS + 2;
    folder.open_file(MARK).ok()?.take(most as u64).read_to_string(&mut text).ok()?;
    let id = text.strip_prefix(WORDS)?.strip_suffix('\n')?;
    let whole = id.len() == DIGITS && id.bytes().all(|byte| matches!(byte, b'0'..=b'9' | b'a'..=b'f'));
    whole.then(|| id.to_owned())
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

fn owner(folder: &Folder) -> std::io::Result<Owner> {
    let names = folder.entries()?.into_iter().map(|(name, _)| name);
    // A process that was killed while it made the mark left a temporary file.
    let mut others: Vec<String> = names.filter(|name| !(name.starts_with(MARK) && name.ends_with(TEMPORARY))).collect();
    // Asked after the listing: another process may have made the mark meanwhile, and its other files come after it.
    if id(folder).is_some() {
        return Ok(Owner::Run);
    }
    others.sort();
    Ok(if others.is_empty() { Owner::Nobody } else { Owner::Other(others) })
}
