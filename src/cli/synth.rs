//! `gonio synth`: data with a known truth.

use std::io;
use std::path::{Path, PathBuf};

use clap::{Args, Subcommand, ValueEnum};

use super::deadline::with_deadline;
use super::ending::{Answer, Ending};
use super::print::{err, out};
use super::streams::write_out;
use crate::base::{Error, Result};
use crate::codec::tables::npy;
use crate::disk::write_atomic;
use crate::flow::deadline::GRACE;
use crate::flow::{StopSignal, pool};
use crate::synth::city::{self, CityConfig, World};
use crate::synth::sparse::{self, Prior};
use crate::synth::spheres::{Camera, Layout, Published, Samples};

/// The data to make.
#[derive(Debug, Subcommand)]
pub(super) enum Synth {
    /// A small town with its photographs, a COLMAP model, a mesh, and the material of every triangle
    City(City),
    /// Dense reflectance maps of rendered materials: maps.npy [N,3,60,120], materials.npy [N,7], lights.npy [N,3], and
    /// views.npy [N,3] for spheres
    Spheres(Spheres),
    /// Sparse reflectance maps as flights fill them, as a stream of samples for training
    Bins(Bins),
}

/// Options of `synth city`.
#[derive(Debug, Args)]
pub(super) struct City {
    /// The folder to make the city in: new, empty, or with a city in it
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
    /// Seed of everything random
    #[arg(long, default_value_t = CityConfig::default().seed)]
    seed: u64,
    /// Triangles to aim at, 5000 to 20000000
    #[arg(long, default_value_t = CityConfig::default().triangles)]
    triangles: u32,
    /// Photographs, 1 to 100000
    #[arg(long, default_value_t = CityConfig::default().frames)]
    frames: u32,
    /// Columns of a photograph, 16 to 16384
    #[arg(long, default_value_t = CityConfig::default().width)]
    width: u32,
    /// Rows of a photograph, 16 to 16384
    #[arg(long, default_value_t = CityConfig::default().height)]
    height: u32,
    /// Samples of a pixel along either axis, 1 to 4
    #[arg(long, default_value_t = CityConfig::default().supersampling)]
    supersampling: u32,
    /// The sun's height above the horizon, 5 to 90
    #[arg(long, default_value_t = CityConfig::default().sun_elevation_deg, value_name = "DEGREES")]
    sun_elevation_deg: f64,
    /// The sun's direction from +x towards +y
    #[arg(long, default_value_t = CityConfig::default().sun_azimuth_deg, value_name = "DEGREES")]
    sun_azimuth_deg: f64,
    /// A sun as ELEVATION/AZIMUTH in degrees; given again, the flight is shared out among the suns in its order, and each
    /// photograph tells when it was taken
    #[arg(long, value_name = "DEGREES", value_parser = sun, conflicts_with_all = ["sun_elevation_deg", "sun_azimuth_deg"])]
    sun: Vec<[f64; 2]>,
    /// How much of a real town and a real camera the city has
    #[arg(long, value_enum, default_value_t)]
    world: World,
}

/// A sun of the command line.
fn sun(text: &str) -> Result<[f64; 2], String> {
    let two = text.split_once('/').and_then(|(e, a)| Some([e.trim().parse().ok()?, a.trim().parse().ok()?]));
    two.ok_or_else(|| "must be ELEVATION/AZIMUTH in degrees, as 47/228".to_owned())
}

/// Options of `synth spheres`.
#[derive(Debug, Args)]
pub(super) struct Spheres {
    /// A whole training set: 606,000 sphere maps in train, validation and test, f16, 25 GB
    #[arg(long, value_enum, conflicts_with_all = ["kind", "count", "materials", "lights", "views"])]
    preset: Option<Preset>,
    /// The layout of the maps
    #[arg(id = "kind", long = "kind", value_name = "KIND", value_enum, required_unless_present = "preset")]
    layout: Option<MapLayout>,
    /// The number of maps
    #[arg(long, required_unless_present = "preset")]
    count: Option<usize>,
    /// The camera that looks at a sphere [default: orthographic; of a preset: perspective]
    #[arg(long, value_enum)]
    camera: Option<Camera>,
    /// Seed of the materials, lights and views that are not given
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// Materials to render, .npy [N,7]
    #[arg(long, value_name = "FILE.npy")]
    materials: Option<PathBuf>,
    /// Unit vectors to the light in the map's frame, .npy [N,3]
    #[arg(long, value_name = "FILE.npy")]
    lights: Option<PathBuf>,
    /// Unit vectors to the camera in the map's frame, .npy [N,3]; only for spheres
    #[arg(long, value_name = "FILE.npy")]
    views: Option<PathBuf>,
    /// The folder to write to
    #[arg(long, value_name = "DIR")]
    out: PathBuf,
}

/// The training sets that are made whole.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum Preset {
    /// The publication's set: 24,000 materials from 24 sides under one light, and 30,000 maps of other materials for tests
    Published,
}

/// A map's layout without the camera.
#[derive(Debug, Clone, Copy, ValueEnum)]
enum MapLayout {
    /// One surface point; a bin is a direction of reflection
    Lobe,
    /// A unit sphere seen by one camera; a bin is a normal
    Sphere,
}

/// Options of `synth bins`.
#[derive(Debug, Args)]
pub(super) struct Bins {
    /// The number of samples
    #[arg(long)]
    count: u64,
    /// The distribution of materials and lights
    #[arg(long, value_enum, default_value_t = Prior::Uniform)]
    prior: Prior,
    /// Seed of the samples
    #[arg(long, default_value_t = 1)]
    seed: u64,
    /// The file to write, or - for standard output
    #[arg(long, value_name = "FILE")]
    out: PathBuf,
}

/// Makes the data.
///
/// # Errors
/// An option is out of range, a file cannot be written, or the command is interrupted.
pub(super) fn synth(what: Synth) -> Answer {
    let stop = StopSignal::new();
    with_deadline(&stop, GRACE, || pool::share(pool::available(), || made(what, &stop)))???;
    if stop.draining() {
        err("gonio: interrupted, but done");
    }
    Ok(Ending::Done)
}

fn made(what: Synth, stop: &StopSignal) -> Result<()> {
    let stopped = || stop.draining();
    match what {
        Synth::City(c) => {
            let one = match c.sun[..] {
                [one] => one,
                _ => [c.sun_elevation_deg, c.sun_azimuth_deg],
            };
            let config = CityConfig {
                seed: c.seed,
                triangles: c.triangles,
                frames: c.frames,
                width: c.width,
                height: c.height,
                supersampling: c.supersampling,
                sun_elevation_deg: one[0],
                sun_azimuth_deg: one[1],
                suns: if c.sun.len() > 1 { c.sun } else { Vec::new() },
                world: c.world,
                ..CityConfig::default()
            };
            let made = city::generate_if_needed(&c.out, &config, &stopped, &|_| {})?;
            let was = if made.reused { "there already" } else { "made" };
            out(&format!("{}: {} triangles, {} frames; {was}", c.out.display(), made.triangles, made.frames))?;
        }
        Synth::Spheres(s) => match s.layout {
            Some(typed) => {
                let samples = Samples {
                    count: s.count.unwrap_or_default(),
                    seed: s.seed,
                    materials: s.materials.as_deref().map(npy::read_rows).transpose()?,
                    lights: s.lights.as_deref().map(npy::read_rows).transpose()?,
                    views: s.views.as_deref().map(npy::read_rows).transpose()?,
                };
                let layout = match typed {
                    MapLayout::Lobe => Layout::Lobe,
                    MapLayout::Sphere => Layout::Sphere(s.camera.unwrap_or_default()),
                };
                samples.write(layout, &s.out, &stopped)?;
            }
            None => {
                let camera = s.camera.unwrap_or(Camera::Perspective);
                Published::new(s.seed).write(camera, &s.out, &stopped)?;
            }
        },
        Synth::Bins(b) => {
            let write = |to: &mut dyn io::Write| sparse::write(to, b.prior, b.seed, b.count);
            if b.out == Path::new("-") {
                // The reader of the stream takes as many samples as it wants.
                write_out(write)?;
            } else {
                write_atomic(&b.out, |mut to| write(&mut to).map_err(Error::io("write", &b.out)))?;
            }
        }
    }
    Ok(())
}
