//! Corrupt files are moved to the folder `corrupt/`, where people may look at them. So is an obstacle, a folder, link or
//! device where a file ought to be: nothing in it is looked at or removed.

use std::io::ErrorKind;

use super::store::Store;
use crate::base::{Error, Result};

/// The folder of corrupt files. All are kept: the second of a name ends in `.2`, and so on.
pub(super) const CORRUPT: &str = "corrupt";

/// What is wrong with an obstacle, in words.
pub(super) const OBSTACLE: &str = "is no file, but a folder, a link or a device";

/// Moves a corrupt file or an obstacle, which may be gone by now, and gives its new name.
pub(super) fn set_aside(store: &dyn Store, file: &str) -> Result<String> {
    set_aside_as(store, file, file.rsplit('/').next().unwrap_or(file))
}

/// Moves a corrupt file or an obstacle, which may be gone by now, to this name among the corrupt files, and gives its new name.
pub(super) fn set_aside_as(store: &dyn Store, file: &str, name: &str) -> Result<String> {
    let mut kept = kept_as(name);
    for number in 2.. {
        if store.size(&kept)?.is_none() && !store.is_obstructed(&kept)? {
            break;
        }
        kept = kept_as(&format!("{name}.{number}"));
    }
    match store.rename(file, &kept) {
        Ok(()) => Ok(kept),
        // Another process has moved it.
        Err(why) => unless_gone(why).map(|()| kept_as(name)),
    }
}

/// The name under which the first corrupt file of a name is kept.
pub(super) fn kept_as(name: &str) -> String {
    format!("{CORRUPT}/{name}")
}

/// Whether a file is a corrupt one that is kept.
pub(super) fn is_kept(file: &str) -> bool {
    file.split('/').next() == Some(CORRUPT)
}

/// Removes a file, which may be gone by now: another process may have found the same fault.
pub(super) fn remove(store: &dyn Store, file: &str) -> Result<()> {
    store.remove(file).or_else(unless_gone)
}

fn unless_gone(why: Error) -> Result<()> {
    match why {
        Error::Io { source, .. } if source.kind() == ErrorKind::NotFound => Ok(()),
        why => Err(why),
    }
}
