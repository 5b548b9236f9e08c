//! Whether a disk is large enough for what will be written, asked before the first byte is written.

use std::path::{Path, PathBuf};

use crate::base::units::Bytes;
use crate::base::{Error, Result};

/// The free space that a folder needs, and the space that it has.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Space {
    /// The folder, which need not be there yet.
    pub folder: PathBuf,
    /// Bytes that will still be written into the folder.
    pub needs: u64,
    /// Free bytes on the folder's disk; `None` where the system does not say.
    pub free: Option<u64>,
}

impl Space {
    /// Refuses a disk that is too small. `named` is the setting that names the folder, as `[run] work`.
    ///
    /// # Errors
    /// The disk is too small: by how much, where, and what to do.
    pub fn enough(&self, named: &str) -> Result<()> {
        let Some(free) = self.free.filter(|free| *free < self.needs) else { return Ok(()) };
        Err(Error::invalid(format!(
            "the disk of {} is {} too small: about {} will be written there, and {} are free; free that much, or name a \
             folder on another disk with {named}",
            self.folder.display(),
            Bytes(self.needs - free),
            Bytes(self.needs),
            Bytes(free),
        )))
    }
}

/// The bytes that an ordinary user may still write into a folder, there or not; `None` where the system does not say.
pub(crate) fn free(folder: &Path) -> Option<u64> {
    let there = nearest(folder)?;
    #[cfg(unix)]
    return rustix::fs::statvfs(&there).ok().map(|found| found.f_bavail.saturating_mul(found.f_frsize));
    #[cfg(not(unix))]
    return None;
}

/// Whether two folders, there or not, share their free bytes; yes where the system does not say.
pub(crate) fn same_disk(one: &Path, other: &Path) -> bool {
    #[cfg(unix)]
    {
        use std::os::unix::fs::MetadataExt;
        let device = |folder: &Path| nearest(folder)?.metadata().ok().map(|found| found.dev());
        device(one) == device(other)
    }
    #[cfg(not(unix))]
    return true;
}

/// The folder, or the nearest existing folder above it.
fn nearest(folder: &Path) -> Option<PathBuf> {
    let absolute = std::path::absolute(folder).ok()?;
    absolute.ancestors().find(|above| above.exists()).map(Path::to_path_buf)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_disk_that_is_too_small_is_refused_by_how_much() {
        let space = |free| Space { folder: "work".into(), needs: 5 << 30, free };
        assert!(space(None).enough("").is_ok() && space(Some(5 << 30)).enough("").is_ok());
        insta::assert_snapshot!(space(Some(3 << 30)).enough("[run] work").unwrap_err(), @"the disk of work is 2 GiB too small: about 5 GiB will be written there, and 3 GiB are free; free that much, or name a folder on another disk with [run] work");
    }

    #[test]
    fn folders_that_will_be_are_on_the_disk_of_those_above() {
        let dir = tempfile::tempdir().unwrap();
        let (one, other) = (dir.path().join("a/b/c"), dir.path().join("d"));
        assert!(same_disk(&one, &other));
        assert_eq!(free(&one).is_some(), cfg!(unix));
    }
}
