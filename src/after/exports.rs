//! The exports of a finished run, written as they are configured now.

use std::path::PathBuf;
use std::sync::Arc;

use super::finished::Finished;
use crate::base::Result;
use crate::disk::{DirStore, Ledger, Lock, Store};
use crate::flow::pool;
use crate::phases::{PHASES, UnitCount, export_tables, read_report, write_report};
use crate::pipeline::Pipeline;

/// Writes the exports of a finished run that are not there as they are configured now, and gives the paths of all.
///
/// # Errors
/// No finished materials; anything that cannot be read or written.
pub(crate) fn export(pipeline: &Pipeline) -> Result<Vec<PathBuf>> {
    let finished = Finished::open(pipeline)?;
    let store = DirStore::new(&pipeline.run.work);
    let _lock = Lock::acquire(&store)?;
    let store: Arc<dyn Store> = Arc::new(store);
    let (ledger, _) = pool::share(pipeline.run.threads(), || Ledger::open(Arc::clone(&store)))??;
    let report = read_report(&*store);
    let outputs = export_tables(pipeline, &*store, &ledger, &finished.scene.mesh, &finished.tables)?;
    // A report that cannot be read is written anew by the next run.
    if let Ok(Some(mut report)) = report {
        report.units = UnitCount::of(PHASES.iter().map(|phase| phase.name()), &ledger);
        report.outputs.clone_from(&outputs);
        write_report(&*store, &report)?;
    }
    Ok(outputs)
}
