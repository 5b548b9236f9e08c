//! From a pipeline file to a finished run: raw, check, plan, resume, exec.
//!
//! [`check::load`] reads a file and answers with a [`Pipeline`] or with every [`Problem`](problem::Problem) that it has.
//! A `Pipeline` is checked: its values are in range, its paths are resolved, and its inputs were there. From then on
//! nothing asks the file again. [`plan`] says what a run will take, [`exec`] runs it, [`report`] is what it leaves.

pub mod check;
pub mod exec;
pub mod explain;
pub mod inspect;
pub mod judge;
pub mod pairs;
pub mod picture;
pub mod plan;
pub mod problem;
pub mod progress;
mod raw;
pub mod readable;
pub mod report;
pub mod resume;
pub mod room;
pub mod scene;
mod section;
mod shards;
pub mod share;
pub mod trial;

pub use exec::{Foreseen, export, plan, run};
pub use explain::explain;
pub use inspect::{buffers, maps};
pub use plan::Plan;
pub use progress::Progress;
pub use report::Report;

use std::path::PathBuf;

use crate::base::units::Bytes;
use crate::stages::{Choice, cast, decode, export, gather, infer, light, merge};
use crate::synth::city::{self, CityConfig};

/// A pipeline file, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Pipeline {
    /// The file that it came from.
    pub file: PathBuf,
    /// What makes the inputs on the first run, if anything does.
    pub synth: Option<Synth>,
    /// The inputs.
    pub scene: Scene,
    /// How images become radiance.
    pub decode: decode::Config,
    /// How radiance becomes observations.
    pub cast: cast::Config,
    /// How observations become segments.
    pub gather: gather::Config,
    /// How maps become materials.
    pub infer: infer::Config,
    /// What becomes of triangles that were hardly seen.
    pub merge: merge::Config,
    /// What is known of the light.
    pub light: light::Config,
    /// What is written for others.
    pub export: export::Config,
    /// Where and with how much a run runs.
    pub run: Run,
}

impl Pipeline {
    /// Whether the scene is there: it is not while the city that it is has yet to be made, or made to its end.
    pub fn is_made(&self) -> bool {
        let is_here = |synth: &Synth| self.scene.mesh == synth.into.join(MESH);
        self.synth.as_ref().filter(|synth| is_here(synth)).is_none_or(|s| city::is_finished(&s.into, &s.city))
    }
}

/// Section `[synth]`: a scene with a known truth, made where it is missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Synth {
    /// The folder that it is made in; [`MESH`], [`IMAGES`] and [`MODEL`] are in it then.
    pub into: PathBuf,
    /// Which one.
    pub city: CityConfig,
}

/// The mesh in the folder of a scene that was made.
pub const MESH: &str = "mesh.ply";
/// The photographs in the folder of a scene that was made.
pub const IMAGES: &str = "images";
/// The COLMAP model in the folder of a scene that was made.
pub const MODEL: &str = "sparse/0";

/// Section `[scene]`: the inputs. All paths are resolved.
#[derive(Debug, Clone, PartialEq)]
pub struct Scene {
    /// The triangle mesh.
    pub mesh: PathBuf,
    /// The folder of images that the poses name.
    pub images: PathBuf,
    /// The folder of masks, `NAME.png` for an image `NAME`, 0 where a pixel is to be ignored.
    pub masks: Option<PathBuf>,
    /// Where the cameras stand.
    pub poses: Poses,
}

/// Key `poses` of `[scene]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Poses {
    /// The format.
    pub format: PosesFormat,
    /// The file or folder.
    pub path: PathBuf,
}

/// A format of camera poses.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum PosesFormat {
    /// The folder of a COLMAP sparse model, binary or text.
    Colmap,
}

impl Choice for PosesFormat {
    const NAMES: &'static [(&'static str, Self)] = &[("colmap", PosesFormat::Colmap)];
}

/// Section `[run]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Run {
    /// The folder that belongs to this run.
    pub work: PathBuf,
    /// The memory that a run may hold.
    pub memory: Bytes,
    /// Threads for the workers of all stages; 0 for as many as there are.
    pub threads: usize,
}
