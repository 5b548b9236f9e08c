//! From what was written to what is meant: every section and key, typed, in range, its files there. All problems are
//! found before any is reported.

use std::cell::RefCell;
use std::path::Path;

use super::problem::{Problem, Problems, unknown};
use super::raw::{self, Node, Table};
use super::section::{Leads, Reading, Section, To};
use super::{IMAGES, MESH, MODEL, Pipeline, Poses, PosesFormat, Run, Scene, Synth};
use crate::base::units::Bytes;
use crate::stages::{Fault, cast, decode, export, gather, infer, light, merge};
use crate::synth::city::CityConfig;

/// Every section with its keys. Sections within sections are keys of them.
pub const SECTIONS: [(&str, &[&str]); 10] = [
    ("synth", &["into", "city"]),
    ("scene", &["mesh", "images", "masks", "poses"]),
    ("decode", &["transfer", "gamma", "exposure", "downscale"]),
    ("cast", &["tile"]),
    ("gather", &["shadow", "group"]),
    ("infer", &["estimator", "model", "backend", "library", "batch"]),
    ("merge", &["min_bins", "fill"]),
    ("light", &["mode", "sun", "color", "sky"]),
    ("export", &["formats", "up"]),
    ("run", &["work", "memory", "threads"]),
];

/// The keys of `poses` in `[scene]`.
pub const POSES: &[&str] = &["format", "path"];

/// The keys of `city` in `[synth]`.
pub const CITY: &[&str] = &[
    "seed",
    "triangles",
    "frames",
    "width",
    "height",
    "supersampling",
    "sun_elevation_deg",
    "sun_azimuth_deg",
    "sky",
    "jpeg_quality",
];

/// The most threads that can be asked for.
const THREADS: usize = 1024;

/// Reads a pipeline file, lays the `--set` arguments over it, and checks everything. Paths of the file are relative to
/// its folder, paths of arguments to the current one.
///
/// # Errors
/// All problems at once, sorted by their places.
pub fn load(path: &Path, sets: &[String]) -> Result<Pipeline, Problems> {
    let faulty = |mut list: Vec<Problem>| {
        list.sort();
        Problems { file: path.to_owned(), list }
    };
    let mut root = raw::read(path).map_err(faulty)?;
    let refused: Vec<Problem> = sets.iter().filter_map(|s| raw::set(&mut root, s).err()).collect();
    let folder = path.parent().unwrap_or(Path::new(""));
    let reading = Reading { folder, problems: RefCell::new(refused) };
    let pipeline = pipeline(&reading, &root, path);
    let problems = reading.problems.into_inner();
    if problems.is_empty() { Ok(pipeline) } else { Err(faulty(problems)) }
}

fn pipeline(reading: &Reading<'_>, root: &Table, file: &Path) -> Pipeline {
    unknown_sections(reading, root);
    let section = |name: &str| {
        let listed = SECTIONS.iter().find(|(known, _)| *known == name);
        let (name, keys) = listed.copied().unwrap_or_default();
        Section::open(reading, name, keys, root.get(name))
    };
    let synth = root.get("synth").map(|_| synth(reading, &section("synth")));
    let light = light(&section("light"));
    Pipeline {
        file: file.to_owned(),
        scene: scene(reading, &section("scene"), synth.as_ref()),
        synth,
        decode: decode(&section("decode")),
        cast: cast(&section("cast")),
        gather: gather(&section("gather")),
        infer: infer(&section("infer"), &light),
        merge: merge(&section("merge")),
        light,
        export: export(&section("export")),
        run: run(&section("run")),
    }
}

fn unknown_sections(reading: &Reading<'_>, root: &Table) {
    let known = SECTIONS.map(|(name, _)| name);
    for (name, (place, Node { value, .. })) in root {
        if known.contains(&name.as_str()) {
            continue;
        }
        let (rule, mut hint) = unknown(name, &known);
        if !matches!(value, raw::Value::Table(_))
            && let Some((home, _)) = SECTIONS.iter().find(|(_, keys)| keys.contains(&name.as_str()))
        {
            hint = Some(format!("`{name}` is a key of [{home}]"));
        }
        let problem = Problem::new(place.clone(), name, format!("no such section; {rule}"));
        reading.problems.borrow_mut().push(Problem { hint, ..problem });
    }
}

fn synth(reading: &Reading<'_>, s: &Section<'_>) -> Synth {
    let missing = "name a folder for the scene that is made";
    let into = s.required_path("into", Leads { to: To::FolderOrNothing, made: None, missing });
    let c = Section::open(reading, "synth.city", CITY, s.found("city"));
    let (d, before) = (CityConfig::default(), s.problems());
    let city = CityConfig {
        seed: c.whole("seed", d.seed),
        triangles: c.whole("triangles", d.triangles),
        frames: c.whole("frames", d.frames),
        width: c.whole("width", d.width),
        height: c.whole("height", d.height),
        supersampling: c.whole("supersampling", d.supersampling),
        sun_elevation_deg: c.number("sun_elevation_deg").unwrap_or(d.sun_elevation_deg),
        sun_azimuth_deg: c.number("sun_azimuth_deg").unwrap_or(d.sun_azimuth_deg),
        sky: c.numbers("sky", d.sky.map(f64::from)).map(|v| v as f32),
        jpeg_quality: c.whole("jpeg_quality", d.jpeg_quality),
    };
    if let (Err(why), true) = (city.check(), s.problems() == before) {
        s.wrong("city", why.to_string());
    }
    Synth { into, city }
}

fn scene(reading: &Reading<'_>, s: &Section<'_>, synth: Option<&Synth>) -> Scene {
    let made = |name: &str| synth.map(|synth| synth.into.join(name));
    let (mesh, images, model) = (made(MESH), made(IMAGES), made(MODEL));
    let mesh = Leads {
        to: To::File,
        made: mesh.as_deref(),
        missing: "put the mesh there, a PLY or OBJ file, or name it: --set scene.mesh=PATH",
    };
    let images = Leads {
        to: To::Folder,
        made: images.as_deref(),
        missing: "put the photographs there, or name their folder: --set scene.images=PATH",
    };
    let masks = Leads {
        to: To::Folder,
        made: None,
        missing: "name the folder of masks, or take the key out if there are none",
    };
    let model = Leads {
        to: To::Folder,
        made: model.as_deref(),
        missing: "name the folder that holds cameras.bin and images.bin, or both as .txt: --set scene.poses.path=PATH",
    };
    let poses = Section::open(reading, "scene.poses", POSES, s.found("poses"));
    let path = poses.required_path("path", model);
    // What a run makes may be half made.
    let faults = if made(MODEL).as_ref() == Some(&path) { None } else { without_model(&path) };
    poses.faults(faults.into_iter().collect());
    Scene {
        mesh: s.required_path("mesh", mesh),
        images: s.required_path("images", images),
        masks: s.path("masks", masks),
        poses: Poses { format: poses.choice("format", PosesFormat::Colmap), path },
    }
}

/// A fault if a folder that is there holds no COLMAP model.
fn without_model(folder: &Path) -> Option<Fault> {
    let holds = |folder: &Path| {
        ["bin", "txt"]
            .iter()
            .any(|ending| ["cameras", "images"].iter().all(|n| folder.join(n).with_extension(ending).is_file()))
    };
    if !folder.is_dir() || holds(folder) {
        return None;
    }
    let fault = Fault::new("path", "must hold cameras.bin and images.bin, or both as .txt", folder.display());
    let below = ["0", "sparse/0", "sparse"].iter().map(|n| folder.join(n)).find(|below| holds(below));
    Some(match below {
        Some(below) => fault.hint(format!("did you mean {}?", below.display())),
        None => fault,
    })
}

fn decode(s: &Section<'_>) -> decode::Config {
    let d = decode::Config::default();
    let known = s.problems();
    let transfer = s.choice("transfer", d.transfer);
    // A transfer that cannot be read may be the one that wants a gamma.
    let gamma = s.number("gamma").filter(|_| s.problems() == known);
    let exposure = s.choice("exposure", d.exposure);
    let downscale = s.whole("downscale", d.downscale);
    checked(s, decode::Config { transfer, gamma, exposure, downscale }, decode::Config::check)
}

fn cast(s: &Section<'_>) -> cast::Config {
    checked(s, cast::Config { tile: s.whole("tile", cast::Config::default().tile) }, cast::Config::check)
}

fn gather(s: &Section<'_>) -> gather::Config {
    let d = gather::Config::default();
    let config = gather::Config { shadow: s.choice("shadow", d.shadow), group: s.whole("group", d.group) };
    checked(s, config, gather::Config::check)
}

fn infer(s: &Section<'_>, light: &light::Config) -> infer::Config {
    let d = infer::Config::default();
    let file = |missing| Leads { to: To::File, made: None, missing };
    let named = s.meaning("model", d.model, |name| {
        let file = name.to_ascii_lowercase().ends_with(".onnx");
        Ok(if file { infer::Model::File(name.into()) } else { infer::Model::BuiltIn(name.to_owned()) })
    });
    let model = match named {
        infer::Model::File(_) => s
            .path("model", file("name an ONNX file, or a model that gonio brings along"))
            .map_or_else(infer::Model::built_in, infer::Model::File),
        built_in => built_in,
    };
    let library = "name the library file, as libonnxruntime.so, or take the key out";
    let estimator = s.choice("estimator", d.estimator);
    if estimator != infer::Kind::Network && light.mode == light::Mode::Unknown {
        let hint = "set [light] mode = \"known\" and its sun, or estimator = \"network\"";
        s.faults(vec![Fault::new("estimator", "needs a known light where it fits", "an unknown one").hint(hint)]);
    }
    let config = infer::Config {
        estimator,
        model,
        backend: s.choice("backend", d.backend),
        library: s.path("library", file(library)),
        batch: s.whole("batch", d.batch),
    };
    checked(s, config, infer::Config::check)
}

fn merge(s: &Section<'_>) -> merge::Config {
    let d = merge::Config::default();
    let config = merge::Config { min_bins: s.whole("min_bins", d.min_bins), fill: s.truth("fill", d.fill) };
    checked(s, config, merge::Config::check)
}

fn light(s: &Section<'_>) -> light::Config {
    let d = light::Config::default();
    let config = light::Config {
        mode: s.choice("mode", d.mode),
        sun: s.numbers("sun", d.sun),
        color: s.numbers("color", d.color),
        sky: s.numbers("sky", d.sky),
    };
    checked(s, config, light::Config::check)
}

fn export(s: &Section<'_>) -> export::Config {
    let d = export::Config::default();
    let config = export::Config { formats: s.choices("formats", d.formats), up: s.numbers("up", d.up) };
    checked(s, config, export::Config::check)
}

fn run(s: &Section<'_>) -> Run {
    let threads = s.whole("threads", 0usize);
    s.faults(Fault::unless_within("threads", threads, 0..=THREADS).into_iter().collect());
    let size = "must be a number and one of B, KiB, MiB, GiB, TiB, as in \"3GiB\"";
    Run {
        work: s.required_path(
            "work",
            Leads { to: To::FolderOrNothing, made: None, missing: "name a folder for this run" },
        ),
        memory: s.meaning("memory", Bytes(4 * Bytes::GIB), |text| text.parse().map_err(|_: String| size.to_owned())),
        threads,
    }
}

/// A stage's configuration, after the stage has looked at it.
fn checked<C>(s: &Section<'_>, config: C, check: impl Fn(&C) -> Vec<Fault>) -> C {
    s.faults(check(&config));
    config
}

#[cfg(test)]
mod tests;
