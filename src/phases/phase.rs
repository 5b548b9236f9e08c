//! What a phase is.

use std::sync::Arc;

use super::cause::{Cause, between};
use super::context::Context;
use super::facts::Facts;
use super::known::Known;
use super::takes::Takes;
use super::units::{Unit, Units};
use crate::base::{PhaseName, Result};
use crate::disk::Recipe;
use crate::disk::{Ledger, Rotten, Store};
use crate::pipeline::Pipeline;

/// A part of a run that ends before the next begins. All that is about it stands in its own file or folder.
pub(crate) trait Phase: Sync {
    /// The phase's name.
    fn name(&self) -> PhaseName;

    /// The files that people open, under names of their own. Every run holds them against their records.
    fn outputs(&self) -> Vec<&'static str> {
        Vec::new()
    }

    /// Settles what must be settled before the phase's units are known. Only a run does.
    ///
    /// # Errors
    /// Whatever breaks the run.
    fn prepare(&self, run: &mut Context<'_>) -> Result<()> {
        let _ = run;
        Ok(())
    }

    /// The units that the phase consists of, given what is known and what is done.
    ///
    /// # Errors
    /// A file in the run's folder cannot be read.
    fn units(&self, known: &Known<'_>, store: &dyn Store, ledger: &Ledger) -> Result<Units>;

    /// Why a unit is done over, or for the first time: how its recipe differs from those that were done in its place. Without
    /// `now`, those are of a unit that is gone.
    fn causes(&self, now: Option<&Recipe>, before: &[Recipe]) -> Vec<Cause> {
        now.map_or_else(Vec::new, |now| between(now, before))
    }

    /// What is rotten of the files that the phase keeps beside those of its units. Nothing is changed.
    ///
    /// # Errors
    /// A store that fails.
    fn rotten(&self, store: &Arc<dyn Store>, ledger: &Ledger) -> Result<Vec<Rotten>> {
        let _ = (store, ledger);
        Ok(Vec::new())
    }

    /// What the phase takes; `None` where it has nothing to do.
    fn takes(&self, pipeline: &Pipeline, facts: &Facts) -> Option<Takes>;

    /// The bytes that the phase has still to write, of those that it leaves on the disk. A unit that is out of date counts as
    /// done: it is removed before its like is written.
    fn unwritten(&self, takes: &Takes, ledger: &Ledger) -> u64 {
        let done = ledger.of_phase(self.name()).len() as u64;
        let left = takes.units.saturating_sub(done);
        takes.unwritten(left)
    }

    /// Does these units.
    ///
    /// # Errors
    /// Whatever breaks the run.
    fn work(&self, run: &mut Context<'_>, to_do: &[Unit]) -> Result<()>;

    /// Adds to the report what came of the units, of which `done` were done just now.
    ///
    /// # Errors
    /// What the units left cannot be read, or is nothing that a run can go on with.
    fn tell(&self, run: &mut Context<'_>, units: &Units, done: &[Unit]) -> Result<()> {
        let _ = (run, units, done);
        Ok(())
    }
}
