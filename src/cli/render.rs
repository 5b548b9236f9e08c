//! `gonio render`: a frame relit.

use std::path::PathBuf;

use clap::Args;

use crate::base::Result;
use crate::pipeline::Pipeline;
use crate::pipeline::picture::{self, Light};

/// Options of `render`.
#[derive(Debug, Args)]
pub struct Options {
    /// The frame's name, as in the poses
    #[arg(long, value_name = "NAME")]
    frame: String,
    /// The picture to write
    #[arg(long, value_name = "FILE.png")]
    out: PathBuf,
    /// The sun's height above the horizon, the plane across [export] up
    #[arg(long, default_value_t = 45.0, value_name = "DEGREES")]
    sun_elevation_deg: f64,
    /// The sun's direction about [export] up
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

/// Renders it.
///
/// # Errors
/// No finished run, no frame of that name, anything that cannot be read or written.
pub fn render(pipeline: &Pipeline, options: &Options) -> Result<()> {
    let (elevation_deg, azimuth_deg) = (options.sun_elevation_deg, options.sun_azimuth_deg);
    let light = if options.albedo { Light::None } else { Light::Sun { elevation_deg, azimuth_deg, sky: options.sky } };
    picture::render(pipeline, &options.frame, light, options.beside, &options.out)
}
