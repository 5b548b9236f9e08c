//! The list of phases, in the order in which they run.

use super::build::Build;
use super::cast::Cast;
use super::export::Export;
use super::infer::Infer;
use super::light::Light;
use super::load::Load;
use super::look::Look;
use super::merge::Merge;
use super::phase::Phase;
use super::synth::Synth;

/// The phases of a run, in order.
pub(crate) const PHASES: &[&dyn Phase] = &[&Synth, &Load, &Build, &Look, &Light, &Cast, &Infer, &Merge, &Export];
