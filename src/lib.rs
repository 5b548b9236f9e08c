//! gonio recovers how every surface of a scene reflects light, from ordinary aerial photographs.
//!
//! A mesh, the frames and their poses go in. For every triangle a [`Material`] (diffuse rgb, specular rgb, roughness) and the
//! [`Evidence`] behind it come out. A pipeline file says what to work on; [`load`] checks it, [`run`] runs it or goes on where it
//! was stopped, and [`Results`] reads what came of it:
//!
//! ```
//! use gonio::{Progress, Results, StopSignal, TriangleId, load, run};
//!
//! # fn main() -> Result<(), Box<dyn std::error::Error>> {
//! let folder = tempfile::tempdir()?;
//! let file = folder.path().join("city.toml");
//! std::fs::write(
//!     &file,
//!     r#"
//!     synth = { into = "city", city = { triangles = 5000, frames = 4, width = 64, height = 48 } }
//!
//!     [scene]
//!     mesh = "city/mesh.ply"
//!     images = "city/images"
//!     poses = { format = "colmap", path = "city/sparse/0" }
//!
//!     [light]
//!     mode = "known"
//!     sun = [-0.456, -0.507, 0.731]
//!     sky = [0.16, 0.19, 0.24]
//!
//!     [infer]
//!     estimator = "fit"
//!
//!     [run]
//!     work = "work"
//!     "#,
//! )?;
//!
//! let pipeline = load(&file, &[])?;
//! let report = run(&pipeline, &StopSignal::new(), &Progress::new())?;
//! assert_eq!(report.frames.cast, 4);
//!
//! let results = Results::open(&pipeline)?;
//! let material = results.material(TriangleId(0)).ok_or("triangle 0 has no material")?;
//! assert!(material.kd.iter().all(|kd| (0.0..=1.0).contains(kd)));
//! # Ok(())
//! # }
//! ```
//!
//! [`flow`] is the dataflow engine that runs it, and knows nothing of scenes: stages of one's own run on it too. `ARCHITECTURE.md`
//! shows the way of the data and what each folder answers.

#![warn(unreachable_pub)]
#![cfg_attr(not(test), warn(clippy::cast_possible_truncation))]

mod after;
mod base;
mod before;
mod cache;
mod cli;
mod codec;
mod config;
mod disk;
pub mod flow;
mod light;
mod model;
mod phases;
mod pipeline;
mod render;
mod run;
mod scene;
mod shard;
mod stages;
mod synth;
mod trace;

#[doc(hidden)]
pub mod internals;

pub use after::{Results, read_maps};
pub use base::ids::{FrameId, TriangleId};
pub use base::units::Bytes;
pub use base::{Error, PhaseName, Result};
pub use cli::{Allocator, Ending, main, prepare_process};
pub use config::{Position, Problem, Problems};
pub use flow::StopSignal;
pub use phases::{
    Cause, FrameChange, FrameCounts, FrameInput, LightReport, PhaseProgress, PhaseReport, Progress, Report,
    ShardCounts, StageReport, State, TriangleCounts, UnitCount, share_done, time_left,
};
pub use pipeline::{Pipeline, load, template};
pub use run::{Explanation, Foreseen, PhaseExplanation, Plan, PlannedPhase, explain, find_light, plan, run};
pub use scene::Material;
pub use scene::evidence::{Evidence, Filled};
pub use scene::georeference::{Crs, Georeference};
pub use scene::reflectance::{Bin, BinSum, SparseMap, direction_of};
