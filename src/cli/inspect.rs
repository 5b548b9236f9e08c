//! `gonio buffers` and `gonio maps`: looks into a scene and into a finished run.

use std::path::PathBuf;

use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use crate::after;
use crate::base::ids::TriangleId;

/// Options of `buffers`.
#[derive(Debug, clap::Args)]
pub(super) struct BuffersArgs {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// The frame's name, as in the poses
    #[arg(long, value_name = "NAME")]
    frame: String,
    /// The file to write
    #[arg(long, value_name = "FILE.exr")]
    out: PathBuf,
}

/// Options of `maps`.
#[derive(Debug, clap::Args)]
pub(super) struct MapsArgs {
    /// The pipeline.
    #[command(flatten)]
    pub pipeline: PipelineArgs,
    /// The triangles' positions in the mesh file, from 0, with commas
    #[arg(long, value_name = "T,T,..", value_delimiter = ',', required = true)]
    pub triangles: Vec<u32>,
    /// The file to write: .npz holds map [N,60,120,3] and count [N,60,120], .png shows them
    #[arg(long, value_name = "FILE.npz|FILE.png")]
    pub out: PathBuf,
}

/// Writes a frame's buffers.
pub(super) fn buffers(args: &BuffersArgs) -> Answer {
    after::buffers(&args.pipeline.load()?, &args.frame, &args.out)?;
    Ok(Ending::Done)
}

/// Writes triangles' maps.
pub(super) fn maps(args: &MapsArgs) -> Answer {
    let triangles: Vec<TriangleId> = args.triangles.iter().copied().map(TriangleId).collect();
    after::maps(&args.pipeline.load()?, &triangles, &args.out)?;
    Ok(Ending::Done)
}
