//! Corrupt files are moved to the folder `corrupt/`, where people may look at them.

use std::io::ErrorKind;

use super::store::Store;
use crate::base::{Error, Result};

/// The folder of corrupt files. Of several with one name the last is kept.
pub(super) const CORRUPT: &str = "corrupt";

/// Moves a corrupt file, which may be gone by now, and gives its new name.
pub(super) fn set_aside(store: &dyn Store, file: &str) -> Result<String> {
    let kept = kept_as(file.rsplit('/').next().unwrap_or(file));
    set_aside_as(store, file, &kept)?;
    Ok(kept)
}

/// The name under which a corrupt file is kept.
pub(super) fn kept_as(name: &str) -> String {
    format!("{CORRUPT}/{name}")
}

/// Moves a corrupt file, which may be gone by now, to this name.
pub(super) fn set_aside_as(store: &dyn Store, file: &str, kept: &str) -> Result<()> {
    store.rename(file, kept).or_else(unless_gone)
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
