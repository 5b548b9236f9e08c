//! Synth: the city of `[synth]` is made where it is missing.

use super::context::Context;
use super::facts::Facts;
use super::known::Known;
use super::phase::Phase;
use super::takes::Takes;
use super::units::{Unit, Units};
use crate::base::{PhaseName, Result};
use crate::disk::{Ledger, Store};
use crate::flow::pool;
use crate::pipeline::Pipeline;
use crate::synth::city;

/// The phase. It keeps no units: the city's own folder says how far it is.
pub(super) struct Synth;

impl Phase for Synth {
    fn name(&self) -> PhaseName {
        PhaseName::Synth
    }

    fn units(&self, known: &Known<'_>, _: &dyn Store, _: &Ledger) -> Result<Units> {
        Ok(if known.pipeline.synth.is_some() { Units::unkept() } else { Units::absent() })
    }

    /// A city is made before the rest is planned; what it takes of the disk is asked of its folder.
    fn takes(&self, _: &Pipeline, _: &Facts) -> Option<Takes> {
        None
    }

    fn work(&self, run: &mut Context<'_>, _: &[Unit]) -> Result<()> {
        let Some(synth) = &run.pipeline.synth else { return Ok(()) };
        let (threads, stop, progress) = (run.pipeline.run.threads(), &run.stop, run.progress);
        let taken = |photographs: usize| progress.count(photographs as u64, synth.city.frames.into());
        let make = || city::generate_if_needed(&synth.into, &synth.city, &|| stop.draining(), &taken);
        pool::share(threads, make)?.map(drop)
    }
}
