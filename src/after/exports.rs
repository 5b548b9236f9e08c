//! The exports of a finished run, written as they are configured now.

use std::path::PathBuf;
use std::sync::Arc;

use super::finished::Finished;
use crate::base::Result;
use crate::disk::{DirStore, Ledger, Lock, Store};
use crate::flow::pool;
use crate::phases::export_tables;
use crate::pipeline::Pipeline;

/// Writes the exports of a finished run that are not there as they are configured now, and gives the paths of all.
///
/// # Errors
/// No finished materials; anything that cannot be read or written.
pub(crate) fn export(pipeline: &Pipeline) -> Result<Vec<PathBuf>> {
    let finished = Finished::open(pipeline)?;
    let _lock = Lock::acquire(&pipeline.run.work)?;
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&pipeline.run.work));
    let (ledger, _) = pool::share(pipeline.run.threads(), || Ledger::open(Arc::clone(&store)))??;
    export_tables(pipeline, &*store, &ledger, &finished.scene.mesh, &finished.tables)
}
