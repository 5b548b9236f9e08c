//! `gonio render`: a frame relit.

use std::path::PathBuf;

use super::ending::{Answer, Ending};
use super::pipeline_args::PipelineArgs;
use crate::after::{self, Light};

/// Options of `render`.
#[derive(Debug, clap::Args)]
pub(super) struct Args {
    /// The pipeline.
    #[command(flatten)]
    pipeline: PipelineArgs,
    /// The frame's name, as in the poses
    #[arg(long, value_name = "NAME")]
    frame: String,
    /// The picture to write
    #[arg(long, value_name = "FILE.png")]
    out: PathBuf,
    /// The sun's height above the horizon, the plane across [scene] up
    #[arg(long, default_value_t = 45.0, value_name = "DEGREES")]
    sun_elevation_deg: f64,
    /// The sun's direction about [scene] up
    #[arg(long, default_value_t = 0.0, value_name = "DEGREES")]
    sun_azimuth_deg: f64,
    /// Radiance of the sky, 0 to 1
    #[arg(long, default_value_t = 0.2)]
    sky: f32,
    /// Show the diffuse colours alone, without any light
    #[arg(long)]
    albedo: bool,
    /// Put the photograph to the left
    #[arg(long)]
    beside: bool,
}

/// Renders a frame.
pub(super) fn render(args: &Args) -> Answer {
    let (elevation_deg, azimuth_deg) = (args.sun_elevation_deg, args.sun_azimuth_deg);
    let light = if args.albedo { Light::None } else { Light::Sun { elevation_deg, azimuth_deg, sky: args.sky } };
    after::render(&args.pipeline.load()?, &args.frame, light, args.beside, &args.out)?;
    Ok(Ending::Done)
}
