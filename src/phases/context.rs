//! What the phases of a run share while they work.

use std::sync::Arc;

use super::facts::Facts;
use super::known::Known;
use super::progress::Progress;
use super::report::Report;
use crate::base::Result;
use crate::disk::Recipe;
use crate::disk::{FileEntry, Ledger, Store};
use crate::flow::{Budget, StopSignal};
use crate::pipeline::Pipeline;

/// A run under way.
pub(crate) struct Context<'a> {
    /// The pipeline.
    pub pipeline: &'a Pipeline,
    /// Whether to stop.
    pub stop: StopSignal,
    /// Where the run says how far it is.
    pub progress: &'a Progress,
    /// The run's folder.
    pub store: Arc<dyn Store>,
    /// The units that are done.
    pub ledger: Arc<Ledger>,
    /// The memory that the run may hold.
    pub budget: Budget,
    /// What refuses a memory limit that cannot work, given the figures of the scene.
    pub refuses: &'a (dyn Fn(&Pipeline, &Facts) -> Result<()> + Sync),
    /// What is known of the scene.
    pub known: Known<'a>,
    /// What the run did so far.
    pub report: Report,
}

impl Context<'_> {
    /// Commits a unit whose files are written.
    ///
    /// # Errors
    /// Files that are not there, or a store that fails.
    pub(crate) fn commit(&self, recipe: &Recipe, files: Vec<FileEntry>) -> Result<()> {
        self.ledger.commit(recipe, files).map(drop)
    }
}
