//! Groups of frames are committed under the recipe of what was read of their files, whatever the files hold later.

use std::collections::BTreeMap;
use std::sync::{Mutex, PoisonError};

use super::groups::Group;
use crate::base::Result;
use crate::base::ids::FrameId;
use crate::disk::{FileEntry, Ledger, Recipe, UnitName};
use crate::scene::frame::Frame;
use crate::stages::decode::Contents;
use crate::stages::gather::GroupFrames;

/// Commits the groups of a phase, and keeps what each turned out to be made of.
pub(crate) struct Commits<'a> {
    ledger: &'a Ledger,
    /// All frames, sorted by name.
    frames: &'a [Frame],
    read: Mutex<BTreeMap<UnitName, Recipe>>,
}

impl<'a> Commits<'a> {
    /// No commits yet, of groups of these frames.
    pub(crate) fn new(ledger: &'a Ledger, frames: &'a [Frame]) -> Self {
        Commits { ledger, frames, read: Mutex::default() }
    }

    /// Commits a group whose files are written, of what was read of its frames.
    ///
    /// # Errors
    /// A unit record that cannot be written.
    pub(crate) fn commit(
        &self,
        group: &GroupFrames,
        contents: &[(FrameId, Contents)],
        files: Vec<FileEntry>,
    ) -> Result<()> {
        let recipe = Group::read(&group.recipe, self.frames, contents);
        self.ledger.commit(&recipe, files)?;
        self.read.lock().unwrap_or_else(PoisonError::into_inner).insert(group.recipe.unit(), recipe);
        Ok(())
    }

    /// The recipes of the groups that were committed, by the names of the units that they were begun as.
    pub(crate) fn recipes(self) -> BTreeMap<UnitName, Recipe> {
        self.read.into_inner().unwrap_or_else(PoisonError::into_inner)
    }
}
