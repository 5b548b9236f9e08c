//! Infer: segments become materials, a shard a unit.

mod estimator;
mod phase;
mod shards;
mod share;

pub(crate) use estimator::{TriedEstimator, load_estimator};
pub(crate) use phase::Infer;
pub(super) use phase::{ROW_BYTES, shards_done};
