//! The stages of a run. Each file is a stage: its config, the check of that config, the stage, its tests.

pub mod fill;
