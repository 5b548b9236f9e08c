//! Whole runs on cities of any size: wall time of each phase, peak of the memory that the system cannot take back, disk, and
//! the cost of a kill. At full size a run takes hours, so the bench does nothing without options:
//!
//! ```text
//! cargo bench --bench scale -- --work DIR --triangles 2000000 --frames 100,400,1600 --memory 3GiB
//! cargo bench --bench scale -- --work DIR --triangles 10000000 --frames 2000 --memory 3GiB --kills 10 --kill-after 120
//! cargo bench --bench scale -- --work DIR --triangles 40000000 --field --memory 8GiB
//! ```
//!
//! One city with the most frames is made and kept in DIR; runs with fewer frames spread them over its flight. With `--field`
//! one small frame looks at a height field: the cost of the mesh alone. The table goes to standard output, and every figure
//! as a line of JSON to `--out`.
#![expect(clippy::print_stdout, clippy::print_stderr, reason = "a bench is a program")]

mod field;
mod process;

use std::collections::BTreeMap;
use std::fs::{self, OpenOptions};
use std::io::{self, Error, Write};
use std::path::{Path, PathBuf};
use std::time::Duration;

use clap::Parser;
use gonio::internals::codec::poses::colmap::{self, Encoding};
use gonio::internals::codec::poses::{self, COLMAP};
use gonio::internals::scene::frame::Frame;
use process::{Commits, Course, Ran, course, gonio};
use serde_json::{Value, json};

/// Whole runs on cities of any size.
#[derive(Parser)]
struct Options {
    /// Given by cargo
    #[arg(long, hide = true)]
    bench: bool,
    /// The folder of cities and runs
    #[arg(long)]
    work: Option<PathBuf>,
    /// Triangles to aim at
    #[arg(long, default_value_t = 2_000_000)]
    triangles: u32,
    /// Photographs: a run for each count
    #[arg(long, value_delimiter = ',')]
    frames: Vec<u32>,
    /// A height field with one photograph in place of a city
    #[arg(long, conflicts_with = "frames")]
    field: bool,
    /// Columns of a photograph
    #[arg(long, default_value_t = 1600)]
    width: u32,
    /// Rows of a photograph
    #[arg(long, default_value_t = 1200)]
    height: u32,
    /// The memory limit of runs
    #[arg(long, default_value = "3GiB")]
    memory: String,
    /// Threads of runs
    #[arg(long, default_value_t = 2)]
    threads: u32,
    /// Kills of a second run, spread over its time; of the only run, where --kill-after is given
    #[arg(long, default_value_t = 0)]
    kills: u32,
    /// Seconds from a start to the kill
    #[arg(long, requires = "kills")]
    kill_after: Option<f64>,
    /// The file that gets a line of JSON for every run
    #[arg(long)]
    out: Option<PathBuf>,
}

fn main() -> io::Result<()> {
    let options = Options::parse();
    let Some(work) = options.work.as_deref().filter(|_| options.field || !options.frames.is_empty()) else {
        eprintln!("nothing to do: name --work, and --frames or --field (see benches/scale)");
        return Ok(());
    };
    println!(
        "| triangles | frames | city | load | build | look | light | cast | infer | merge | export | all | peak memory | disk | the costliest kill |"
    );
    println!("|---|---|---|---|---|---|---|---|---|---|---|---|---|---|---|");
    let told = |figures: Value| {
        println!("{}", row(&figures));
        let Some(out) = &options.out else { return Ok(()) };
        writeln!(OpenOptions::new().create(true).append(true).open(out)?, "{figures}")
    };
    if options.field {
        let scene = work.join(format!("field-{}", options.triangles));
        field::make(&scene, options.triangles)?;
        return told(measure(&options, work, &Input { model: scene.join("sparse/0"), scene, frames: 1, made: None })?);
    }
    let city = City::make(&options, work)?;
    options.frames.iter().try_for_each(|&frames| told(measure(&options, work, &city.input(work, frames)?)?))
}

/// The inputs of a run.
struct Input<'a> {
    /// The folder with mesh and photographs.
    scene: PathBuf,
    /// The COLMAP model with the poses.
    model: PathBuf,
    frames: u32,
    /// The making of the city.
    made: Option<&'a Ran>,
}

/// The city of all runs.
struct City {
    folder: PathBuf,
    /// The making of the city.
    made: Ran,
}

impl City {
    /// Makes the city with the frames of the largest run.
    fn make(options: &Options, work: &Path) -> io::Result<City> {
        let Options { triangles, width, height, .. } = options;
        let frames = options.frames.iter().max().copied().unwrap_or(1);
        let folder = work.join(format!("city-{triangles}x{frames}-{width}x{height}"));
        let args = format!("--triangles {triangles} --frames {frames} --width {width} --height {height}");
        let made = gonio(&format!("synth city --out {} {args} --supersampling 1", folder.display()), None)?.whole()?;
        Ok(City { folder, made })
    }

    /// The inputs of a run with this many frames, spread over the flight.
    fn input(&self, work: &Path, frames: u32) -> io::Result<Input<'_>> {
        let all = poses::read(&COLMAP, &self.folder.join("sparse/0"), &poses::NoPhotographs).map_err(Error::other)?;
        let spread: Vec<Frame> = (0..frames as usize).map(|i| all[i * all.len() / frames as usize].clone()).collect();
        let model = work.join(format!("sparse-{frames}-of-{}", all.len()));
        fs::create_dir_all(&model)?;
        colmap::write_model(&model, &spread, Encoding::Binary).map_err(Error::other)?;
        Ok(Input { scene: self.folder.clone(), model, frames, made: Some(&self.made) })
    }
}

/// Runs on a scene, and then again with kills.
fn measure(options: &Options, work: &Path, input: &Input<'_>) -> io::Result<Value> {
    let Options { triangles, width, height, memory, threads, kills, .. } = options;
    let frames = input.frames;
    let name = format!("{triangles}x{frames}-{width}x{height}");
    let file = work.join(format!("{name}.toml"));
    fs::write(&file, pipeline(input, memory, *threads))?;
    let run = |folder: &Path, kills: u32, after: Duration| {
        fs::remove_dir_all(folder).or_else(ignore_missing)?;
        course(&format!("run {} --json --set run.work={}", file.display(), folder.display()), folder, kills, after)
    };

    let folder = work.join(format!("run-{name}"));
    let first_kills = if options.kill_after.is_some() { *kills } else { 0 };
    let whole = run(&folder, first_kills, Duration::from_secs_f64(options.kill_after.unwrap_or(0.0)))?;
    let report: Value = serde_json::from_slice(&fs::read(folder.join("report.json"))?)?;
    let mut figures = json!({
        "triangles": report["triangles"]["total"], "frames": frames, "size": [width, height], "memory": memory,
        "threads": threads, "city_seconds": input.made.map(|made| made.wall.as_secs_f64()),
        "city_peak": input.made.map(|made| made.peak), "run": told(&whole), "disk": size(&folder)?, "units": Commits::of(&folder).units,
        "report": report,
    });
    if *kills > first_kills {
        let second = work.join(format!("killed-{name}"));
        let killed = run(&second, *kills, whole.wall / (kills + 1))?;
        figures["killed"] = told(&killed);
        for output in ["materials.npy", "evidence.npy", "export/scene.ply", "export/scene.glb"] {
            if !same(&folder.join(output), &second.join(output))? {
                return Err(Error::other(format!("{output} of the killed run differs")));
            }
        }
    }
    Ok(figures)
}

fn told(course: &Course) -> Value {
    let seconds = |d: &Duration| d.as_secs_f64();
    let phases: BTreeMap<&str, f64> = course.phases.iter().map(|(name, took)| (name.as_str(), seconds(took))).collect();
    let lost: Vec<f64> = course.lost.iter().map(seconds).collect();
    json!({ "seconds": seconds(&course.wall), "peak": course.peak, "phases": phases, "lost": lost })
}

fn pipeline(input: &Input<'_>, memory: &str, threads: u32) -> String {
    format!(
        "[scene]\nmesh = \"{0}/mesh.ply\"\nimages = \"{0}/images\"\n\
         poses = {{ format = \"colmap\", path = \"{1}\" }}\n\
         [run]\nwork = \"unused\"\nmemory = \"{memory}\"\nthreads = {threads}\n",
        input.scene.display(),
        input.model.display()
    )
}

fn row(figures: &Value) -> String {
    let seconds = |value: &Value| value.as_f64().map_or("-".to_owned(), |s| format!("{s:.1} s"));
    let mib = |value: &Value| value.as_u64().map_or("-".to_owned(), |b| format!("{} MiB", b >> 20));
    let run = &figures["run"];
    let lost = [run, &figures["killed"]].map(|run| run["lost"].as_array().into_iter().flatten());
    let most = lost.into_iter().flatten().filter_map(Value::as_f64).reduce(f64::max);
    let mut cells =
        vec![figures["triangles"].to_string(), figures["frames"].to_string(), seconds(&figures["city_seconds"])];
    cells.extend(
        ["load", "build", "look", "light", "cast", "infer", "merge", "export"]
            .map(|name| seconds(&run["phases"][name])),
    );
    cells.extend([seconds(&run["seconds"]), mib(&run["peak"]), mib(&figures["disk"])]);
    cells.push(seconds(&json!(most)));
    format!("| {} |", cells.join(" | "))
}

/// Bytes of all files below a folder.
fn size(folder: &Path) -> io::Result<u64> {
    let mut sum = 0;
    for entry in fs::read_dir(folder)? {
        let (path, kind) = entry.map(|e| (e.path(), e.file_type()))?;
        sum += if kind?.is_dir() { size(&path)? } else { fs::metadata(&path)?.len() };
    }
    Ok(sum)
}

fn same(one: &Path, other: &Path) -> io::Result<bool> {
    let hash = |path: &Path| -> io::Result<_> {
        Ok(blake3::Hasher::new().update_reader(std::fs::File::open(path)?)?.finalize())
    };
    Ok(hash(one)? == hash(other)?)
}

fn ignore_missing(why: Error) -> io::Result<()> {
    if why.kind() == io::ErrorKind::NotFound { Ok(()) } else { Err(why) }
}
