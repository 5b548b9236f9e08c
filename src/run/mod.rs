//! How does a run go, and how is it foretold and explained? Every file here is a loop over the list of phases and knows none of
//! them by name.

mod execute;
mod explain;
mod mend;
mod plan;
#[cfg(test)]
mod tests;
mod verify;

pub use execute::{find_light, run};
pub use explain::{Explanation, PhaseExplanation, explain};
pub(crate) use plan::inputs;
pub use plan::{Foreseen, Plan, PlannedPhase, plan};
pub(crate) use verify::{Verified, verify};
