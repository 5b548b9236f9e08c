//! Whether a disk has room for what is to be written, asked before anything is.

use std::path::{Path, PathBuf};

use crate::base::units::Bytes;
use crate::base::{Error, Result};

/// A folder, and what is to be written into it.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Room {
    /// The folder; it need not be there yet.
    pub folder: PathBuf,
    /// Bytes that are still to be written into it.
    pub needs: u64,
    /// Bytes that are free there; `None` where nobody says.
    pub free: Option<u64>,
}

impl Room {
    /// Refuses a disk that is too small. `named` is what names the folder, as `[run] work`.
    ///
    /// # Errors
    /// By how much, where, and what to do.
    pub fn enough(&self, named: &str) -> Result<()> {
        let Some(free) = self.free.filter(|free| *free < self.needs) else { return Ok(()) };
        Err(Error::invalid(format!(
            "the disk of {} is {} too small: about {} are still to be written there, and {} are free; free that much, or \
             name a folder on another disk with {named}",
            self.folder.display(),
            Bytes(self.needs - free),
            Bytes(self.needs),
            Bytes(free),
        )))
    }
}

/// The bytes that an ordinary user may still write into a folder that is there or will be; `None` where nobody says.
pub fn free(folder: &Path) -> Option<u64> {
    let there = nearest(folder)?;
    #[cfg(unix)]
    return rustix::fs::statvfs(&there).ok().map(|found| found.f_bavail.saturating_mul(found.f_frsize));
    #[cfg(not(unix))]
    return None;
}

/// Whether two folders, there or not, share their free bytes; yes where nobody says.
pub fn same_disk(one: &Path, other: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let device = |folder: &Path| nearest(folder)?.metadata().ok().map(|found| found.dev());
        device(one) == device(other)
    }
    #[cfg(not(unix))]
    return true;
}

/// The folder, or the nearest above it that is there.
fn nearest(folder: &Path) -> Option<PathBuf> {
    let absolute = std::path::absolute(folder).ok()?;
    absolute.ancestors().find(|above| above.exists()).map(Path::to_path_buf)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_is_too_small_is_refused_by_how_much() {
        let room = |free| Room { folder: "work".into(), needs: 5 << 30, free };
        assert!(room(None).enough("").is_ok() && room(Some(5 << 30)).enough("").is_ok());
        insta::assert_snapshot!(room(Some(3 << 30)).enough("[run] work").unwrap_err(), @"the disk of work is 2 GiB too small: about 5 GiB are still to be written there, and 3 GiB are free; free that much, or name a folder on another disk with [run] work");
    }

    #[test]
    fn folders_that_will_be_are_on_the_disk_of_those_above() {
        let dir = tempfile::tempdir().unwrap();
        let (one, other) = (dir.path().join("a/b/c"), dir.path().join("d"));
        assert!(same_disk(&one, &other));
        assert_eq!(free(&one).is_some(), cfg!(unix));
    }
}
