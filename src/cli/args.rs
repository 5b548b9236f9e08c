//! What was typed.

use std::path::PathBuf;

use clap::{Parser, Subcommand};

use super::{eval, render, synth};
use crate::base::ids::TriangleId;

/// Recovers how every surface of a scene reflects light, from ordinary aerial photographs.
///
/// Exit codes: 0 all done; 1 broken; 2 the command line or the pipeline file is wrong; 3 done, but items were skipped;
/// 130 interrupted, and the same command goes on from there.
#[derive(Debug, Parser)]
#[command(name = "gonio", version)]
pub struct Args {
    /// What to do.
    #[command(subcommand)]
    pub command: Command,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Run a pipeline, or go on where it was stopped
    Run {
        /// Which one.
        #[command(flatten)]
        pipeline: PipelineArgs,
        /// Write events to standard output, one JSON object a line, and nothing else
        #[arg(long)]
        json: bool,
    },
    /// Find every problem of a pipeline file
    Check {
        /// Which one.
        #[command(flatten)]
        pipeline: PipelineArgs,
    },
    /// Say what a run will take: stages, workers, memory, disk and time
    Plan {
        /// Of which pipeline.
        #[command(flatten)]
        pipeline: PipelineArgs,
    },
    /// Say what the next run would do again, and which input or setting is the cause
    Explain {
        /// Of which pipeline.
        #[command(flatten)]
        pipeline: PipelineArgs,
    },
    /// Write what every pixel of a frame sees: triangle, position, normal, depth, uv, as one EXR
    Buffers {
        /// Of which pipeline.
        #[command(flatten)]
        pipeline: PipelineArgs,
        /// The frame's name, as in the poses
        #[arg(long, value_name = "NAME")]
        frame: String,
        /// The file to write
        #[arg(long, value_name = "FILE.exr")]
        out: PathBuf,
    },
    /// Write the reflectance maps of triangles of a finished run
    Maps {
        /// Of which pipeline.
        #[command(flatten)]
        pipeline: PipelineArgs,
        /// Their numbers in the mesh file, from 0, with commas
        #[arg(long, value_name = "T,T,..", value_delimiter = ',', required = true)]
        triangles: Vec<TriangleId>,
        /// The file to write: .npz holds map [N,60,120,3] and count [N,60,120], .png shows them
        #[arg(long, value_name = "FILE.npz|FILE.png")]
        out: PathBuf,
    },
    /// Make data with a known truth
    #[command(subcommand)]
    Synth(synth::Synth),
    /// Show a frame relit: the recovered materials under a sun of your choice, from where the photograph was taken
    Render {
        /// Of which pipeline.
        #[command(flatten)]
        pipeline: PipelineArgs,
        /// How.
        #[command(flatten)]
        options: render::Options,
    },
    /// Measure how far an estimate is from the truth
    #[command(subcommand)]
    Eval(eval::Eval),
    /// Write the exports of a finished run again
    Export {
        /// Of which pipeline.
        #[command(flatten)]
        pipeline: PipelineArgs,
    },
}

/// A pipeline file and what is laid over it.
#[derive(Debug, clap::Args)]
pub struct PipelineArgs {
    /// The pipeline file; pipelines/colmap.toml is one to copy
    #[arg(value_name = "PIPELINE")]
    pub file: PathBuf,
    /// Set a key for this call; a path is then relative to the current folder
    #[arg(long, value_name = "SECTION.KEY=VALUE")]
    pub set: Vec<String>,
}

#[cfg(test)]
mod tests {
    use clap::CommandFactory;

    use super::*;

    #[test]
    fn the_command_line_holds_together() {
        Args::command().debug_assert();
    }

    #[test]
    fn overlays_follow_the_file() {
        let typed = "gonio maps p.toml --set a.b=1 --set c.d=x=y --triangles 1,22,333 --out m.npz";
        let Command::Maps { pipeline, triangles, out } = Args::try_parse_from(typed.split(' ')).unwrap().command else {
            panic!("another command")
        };
        assert_eq!((pipeline.set.len(), triangles, out), (2, vec![1, 22, 333], "m.npz".into()));
    }
}
