//! The list of all sections.

use super::run::Run;
use super::scene::{Poses, Scene};
use super::synth::Synth;
use crate::config::{Outline, Section};
use crate::stages::{cast, decode, export, gather, infer, light, merge};
use crate::synth::city::CityConfig;

/// All sections of a pipeline file.
pub(crate) const SECTIONS: [Outline; 12] = [
    Synth::OUTLINE,
    CityConfig::OUTLINE,
    Scene::OUTLINE,
    Poses::OUTLINE,
    decode::Config::OUTLINE,
    cast::Config::OUTLINE,
    gather::Config::OUTLINE,
    infer::Config::OUTLINE,
    merge::Config::OUTLINE,
    light::Config::OUTLINE,
    export::Config::OUTLINE,
    Run::OUTLINE,
];

/// The keys that never change a result.
#[cfg(test)]
pub(crate) const NEVER_CHANGE_A_RESULT: [&str; 9] = [
    "synth.into",
    "cast.tile",
    "gather.group",
    "infer.batch",
    "run.work",
    "run.memory",
    "run.threads",
    "run.grace",
    "run.verify",
];

/// The sections that are not within another.
pub(super) fn outermost() -> impl Iterator<Item = &'static Outline> {
    SECTIONS.iter().filter(|section| !section.name.contains('.'))
}
