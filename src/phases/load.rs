//! Load: mesh and poses are read, frames are looked at, and the rest of the run is planned.

use super::context::Context;
use super::facts::Facts;
use super::inputs;
use super::known::{Known, Look};
use super::phase::Phase;
use super::takes::{BYTES_PER_SECOND, Takes};
use super::units::{Unit, Units};
use crate::base::{PhaseName, Result};
use crate::disk::{Ledger, Store};
use crate::flow::pool;
use crate::pipeline::Pipeline;

/// The phase. It keeps no units: what is made of the mesh is the next phase's.
pub(super) struct Load;

impl Phase for Load {
    fn name(&self) -> PhaseName {
        PhaseName::Load
    }

    fn units(&self, _: &Known<'_>, _: &dyn Store, _: &Ledger) -> Result<Units> {
        Ok(Units::unkept())
    }

    fn takes(&self, _: &Pipeline, facts: &Facts) -> Option<Takes> {
        (!facts.mapped).then(|| Takes {
            held: facts.mesh,
            held_for: "the mesh",
            seconds: Some(facts.mesh as f64 / BYTES_PER_SECOND),
            ..Takes::default()
        })
    }

    fn work(&self, run: &mut Context<'_>, _: &[Unit]) -> Result<()> {
        let (store, ledger, refuses) = (run.store.clone(), run.ledger.clone(), run.refuses);
        let surveyed = run.known.look(Look::Run, &store, &ledger, refuses)?;
        if let Some(damage) = surveyed.groups.damage() {
            let (page, why, kept) = (&damage.page, &damage.why, damage.kept.join(", "));
            let kept = if kept.is_empty() { kept } else { format!(", which is now {kept}") };
            run.progress.note(format!("the list of frame groups is made over from {page} on{kept}: {why}"));
        }
        run.report.up = inputs::up(run.pipeline).map(|up| up.to_string());
        run.report.georeference = run.pipeline.scene.georeference();
        let casts = surveyed.groups.all().iter().any(|group| !ledger.is_done(&group.recipe.unit()));
        if casts {
            // Photographs that cannot be read are told of when they are skipped.
            let doubts = || inputs::doubts(run.pipeline, &surveyed.scene);
            let doubts = pool::share(run.pipeline.run.threads(), doubts)?;
            doubts.into_iter().for_each(|doubt| run.progress.note(doubt));
        }
        if let Some(damage) = surveyed.light.damage() {
            let (page, why, kept) = (&damage.page, &damage.why, damage.kept.join(", "));
            run.progress
                .note(format!("what was found of the light is found over from {page} on, which is now {kept}: {why}"));
        }
        Ok(())
    }
}
