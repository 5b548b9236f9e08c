//! What does a run consist of? Of phases, one after the other. A phase's file or folder has all that is about it: the units
//! that it consists of, what it takes, its work, and what it tells of that in the end. `plan`, `explain`, `run`, progress and
//! report are loops over the list of phases ([`PHASES`]) and know none of them by name.
//!
//! A unit commits alone: its files first, then its unit record. So a phase that is killed goes on with the units that the
//! ledger lacks.

mod build;
pub(crate) mod cast;
mod cause;
mod context;
mod export;
pub(crate) mod facts;
pub(crate) mod infer;
mod inputs;
mod known;
pub(crate) mod light;
mod list;
mod load;
mod look;
mod merge;
mod phase;
mod photographs;
mod progress;
mod report;
mod report_file;
mod rounded;
mod scene;
mod synth;
pub(crate) mod takes;
mod units;

pub use cause::{Cause, FrameChange, FrameInput};
pub(crate) use context::Context;
pub(crate) use export::export_tables;
pub(crate) use facts::Facts;
pub(crate) use inputs::Inputs;
pub(crate) use known::{Known, Look};
pub(crate) use light::{end_light, middle_place, middle_time};
pub(crate) use list::PHASES;
pub(crate) use phase::Phase;
pub use progress::{PhaseProgress, Progress, State, share_done, time_left};
pub use report::{FrameCounts, LightReport, PhaseReport, Report, ShardCounts, StageReport, TriangleCounts, UnitCount};
pub(crate) use report_file::{REPORT, read_report, remove_report, write_report};
pub(crate) use scene::{LoadedScene, Meshes};
pub(crate) use takes::Takes;
pub(crate) use units::{Extent, Unit, Units};
