//! The worlds that a city may lie in.

use clap::ValueEnum;
use serde::Serialize;

use crate::config::Choice;

/// How much of a real town and a real camera a city has.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum World {
    /// What is assumed of scenes holds: one material a triangle, an even sky, no light between surfaces, the true mesh
    #[default]
    Plain,
    /// Little of that holds: textures, panes and water, a sky with a glow, light from wall to wall, a camera's own tones, and a
    /// mesh as programs reconstruct it
    Real,
}

impl Choice for World {
    const NAMES: &'static [(&'static str, Self)] = &[("plain", World::Plain), ("real", World::Real)];
}

impl World {
    /// Whether the world is the plain one.
    pub(super) fn is_plain(&self) -> bool {
        *self == World::Plain
    }
}
