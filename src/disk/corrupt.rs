//! Corrupt files are moved to the folder `corrupt/`, where people may look at them. So is an obstacle, a folder, link or
//! device where a file ought to be: nothing in it is looked at or removed.

use std::io::ErrorKind;

use super::store::Store;
use crate::base::{Error, Result};

/// The folder of corrupt files. Of several with one name the last is kept.
pub(super) const CORRUPT: &str = "corrupt";

/// What is wrong with an obstacle, in words.
pub(super) const OBSTACLE: &str = "is no file, but a folder, a link or a device";

/// Moves a corrupt file or an obstacle, which may be gone by now, and gives its new name.
pub(super) fn set_aside(store: &dyn Store, file: &str) -> Result<String> {
    set_aside_as(store, file, &kept_as(file.rsplit('/').next().unwrap_or(file)))
}

/// The name under which a corrupt file is kept.
pub(super) fn kept_as(name: &str) -> String {
    format!("{CORRUPT}/{name}")
}

/// Moves a corrupt file or an obstacle, which may be gone by now, to this name or, where an obstacle is in the way, to the
/// next that is free, and gives the name.
pub(super) fn set_aside_as(store: &dyn Store, file: &str, kept: &str) -> Result<String> {
    let replaces = !store.is_obstructed(file)?;
    let is_free =
        |name: &str| -> Result<bool> { Ok(!store.is_obstructed(name)? && (replaces || store.size(name)?.is_none())) };
    let mut name = kept.to_owned();
    for number in 2.. {
        if is_free(&name)? {
            break;
        }
        name = format!("{kept}-{number}");
    }
    store.rename(file, &name).or_else(unless_gone)?;
    Ok(name)
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
