//! The pipeline file that a command names, and the settings laid over it.

use std::ffi::OsString;
use std::path::PathBuf;

use crate::config::Problems;
use crate::pipeline::{Pipeline, load};

/// A pipeline file and the settings laid over it.
#[derive(Debug, clap::Args)]
pub(super) struct PipelineArgs {
    /// The pipeline file, or a folder with gonio.toml; `gonio init` writes one
    #[arg(value_name = "PIPELINE")]
    pub file: PathBuf,
    /// Set a key for this call; a path is then relative to the current folder
    #[arg(long, value_name = "SECTION.KEY=VALUE")]
    pub set: Vec<OsString>,
}

impl PipelineArgs {
    /// Reads and checks the file.
    ///
    /// # Errors
    /// All problems of the file and of the settings.
    pub(super) fn load(&self) -> Result<Pipeline, Problems> {
        load(&self.file, &self.set)
    }
}
