//! What the next run would do over, and why.

use std::collections::BTreeSet;

use crate::base::{PhaseName, Result};
use crate::disk::{DirStore, Ledger, Store};
use crate::disk::{Recipe, UnitName};
use crate::flow::pool;
use crate::phases::{Cause, Extent, Known, Look, PHASES, Phase, Unit, Units};
use crate::pipeline::Pipeline;
use std::sync::Arc;

/// What the next run would do over, phase by phase.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Explanation {
    /// The phases that keep units, in order.
    pub phases: Vec<PhaseExplanation>,
    /// What photographs that came later say of the light, where they contradict the one that was found and stays.
    pub moved: Option<String>,
}

/// What the next run would do over in a phase.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct PhaseExplanation {
    /// The phase's name.
    pub name: PhaseName,
    /// The plural noun for what is counted: "frames".
    pub noun: &'static str,
    /// How many there are; `None` where that is not known before an earlier phase is done.
    pub total: Option<u64>,
    /// How many are done over, or for the first time; at least, where `total` is not known.
    pub again: u64,
    /// The causes, each once.
    pub causes: Vec<Cause>,
}

impl Explanation {
    /// Whether the next run has nothing to do.
    pub fn is_nothing(&self) -> bool {
        self.phases.iter().all(|phase| phase.again == 0 && phase.total.is_some())
    }
}

/// Compares what the pipeline is made of now with what was done. Changes nothing.
///
/// # Errors
/// Inputs, a model or unit records that cannot be read.
pub fn explain(pipeline: &Pipeline) -> Result<Explanation> {
    explain_phases(PHASES, pipeline)
}

pub(super) fn explain_phases(phases: &[&dyn Phase], pipeline: &Pipeline) -> Result<Explanation> {
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&pipeline.run.work));
    let (ledger, _) = pool::share(pipeline.run.threads(), || Ledger::read(Arc::clone(&store)))??;
    let mut known = Known::new(pipeline)?;
    known.look(Look::Explain, &store, &ledger, &|_, _| Ok(()))?;
    let moved = known.surveyed()?.light.state().moved.as_ref().map(|moved| moved.words.clone());
    let mut explanation = Explanation { phases: Vec::new(), moved };
    for phase in phases {
        let units = phase.units(&known, &*store, &ledger)?;
        if !matches!(units.extent, Extent::Unkept | Extent::Absent) {
            explanation.phases.push(explained(*phase, &units, &ledger)?);
        }
    }
    Ok(explanation)
}

pub(super) fn explained(phase: &dyn Phase, units: &Units, ledger: &Ledger) -> Result<PhaseExplanation> {
    let renewed = units.extent == Extent::Renewed;
    let again: Vec<&Unit> = units.all.iter().filter(|unit| renewed || !ledger.is_done(&unit.name)).collect();
    let mut causes = BTreeSet::new();
    let read = |units: Vec<UnitName>| units.iter().map(|unit| ledger.recipe(unit)).collect::<Result<Vec<Recipe>>>();
    for unit in &again {
        let before = read(ledger.find(phase.name(), unit.recipe.what()))?;
        causes.extend(phase.causes(Some(&unit.recipe), &before));
    }
    // Units whose like is no longer wanted leave nothing to do but in what was made of them.
    let wanted: BTreeSet<&str> = units.all.iter().map(|unit| unit.recipe.what()).collect();
    let gone = read(ledger.of_phase(phase.name()))?.into_iter().filter(|recipe| !wanted.contains(recipe.what()));
    causes.extend(phase.causes(None, &gone.collect::<Vec<_>>()));
    if renewed || units.extent == Extent::AtLeast {
        causes.insert(Cause::Upstream);
    }
    let total = (units.extent != Extent::AtLeast).then(|| units.all.iter().map(|unit| unit.weight).sum());
    let again = again.iter().map(|unit| unit.weight).sum();
    Ok(PhaseExplanation { name: phase.name(), noun: units.noun, total, again, causes: causes.into_iter().collect() })
}
