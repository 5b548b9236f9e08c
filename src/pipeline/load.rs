//! From the text of a pipeline file to a [`Pipeline`]. All problems are found before any is reported.

use std::borrow::Cow;
use std::ffi::OsString;
use std::path::Path;

use super::pipeline::Pipeline;
use super::run::Run;
use super::scene::Scene;
use super::sections::outermost;
use super::synth::Synth;
use crate::base::shown::quoted;
use crate::config::raw::{self, Toml};
use crate::config::{Document, Faults, Keys, Position, Problem, Problems, Section, unknown};
use crate::stages::light::Mode;
use crate::stages::{infer, light};

/// The name of the pipeline file of a project's folder.
pub(crate) const FILE: &str = "gonio.toml";

/// The pipeline file at a path: the path, or the file of a folder.
fn file_at(path: &Path) -> Result<Cow<'_, Path>, Problem> {
    if !path.is_dir() {
        return Ok(path.into());
    }
    let file = path.join(FILE);
    if file.exists() {
        return Ok(file.into());
    }
    let folder = quoted(&path.display().to_string());
    let rule = format!("is a folder without a pipeline file, which would be {FILE}");
    Err(Problem::new(rule).hint(format!("gonio init {folder} writes one, or name a file")))
}

/// Reads a pipeline file, or that of a folder, lays the `--set` arguments over it, and checks everything. Paths in the file are relative to its
/// folder, paths in arguments to the current folder.
///
/// # Errors
/// The first 50 problems at once, sorted by position, and the number of the others; north that cannot be told, once all else is
/// well, since it depends on the way up.
pub fn load(path: &Path, sets: &[OsString]) -> Result<Pipeline, Problems> {
    let path = &file_at(path).map_err(|problem| Faults::from(problem).of_file(path))?;
    let mut root = raw::read(path).map_err(|faults| faults.of_file(path))?;
    let mut refused = Faults::default();
    sets.iter().filter_map(|set| raw::set(&mut root, set).err()).for_each(|problem| refused.add(problem));
    let document = Document::new(&root, path, refused);
    let mut pipeline = read(&document, path);
    let faults = document.into_faults();
    if !faults.is_empty() {
        return Err(faults.of_file(path));
    }
    pipeline.scene.find_coordinates(pipeline.synth.is_some());
    if pipeline.light.mode == Mode::Ephemeris {
        let north = pipeline.scene.georeference().and_then(|place| place.north());
        pipeline.light.north = pipeline.light.north.or(north.map(|north| north.to_array()));
    }
    if pipeline.light.mode == Mode::Ephemeris
        && let Err(problem) = pipeline.light.north(pipeline.scene.up)
    {
        return Err(Faults::from(problem.at(Position::Whole, "light.north")).of_file(path));
    }
    Ok(pipeline)
}

fn read(document: &Document<'_>, file: &Path) -> Pipeline {
    unknown_sections(document);
    let run: Run = section(document);
    // The folder comes first: the paths that are read after it must lie elsewhere.
    if !run.work.as_os_str().is_empty() {
        document.works_in(&run.work);
    }
    let synth: Option<Synth> = document.root.contains_key(Synth::NAME).then(|| section(document));
    for (field, path) in synth.iter().flat_map(Synth::makes) {
        document.makes(field, path);
    }
    let (lit, inferring) = (Keys::of(document, light::Config::OUTLINE), Keys::of(document, infer::Config::OUTLINE));
    let (light, infer) = (light::Config::read(&lit), infer::Config::read(&inferring));
    if lit.is_good("mode") {
        infer.check_light(&light, &inferring);
    }
    Pipeline {
        file: file.to_owned(),
        synth,
        scene: section::<Scene>(document),
        decode: section(document),
        cast: section(document),
        gather: section(document),
        infer,
        merge: section(document),
        light,
        export: section(document),
        run,
    }
}

fn section<S: Section>(document: &Document<'_>) -> S {
    S::read(&Keys::of(document, S::OUTLINE))
}

fn unknown_sections(document: &Document<'_>) {
    let known: Vec<&str> = outermost().map(|section| section.name).collect();
    let entries = document.root.iter().filter(|(name, _)| !known.contains(&name.as_str()));
    let others = entries.map(|(name, (position, node))| (position, (name, &node.value))).collect();
    document.add_many(others, |(position, (name, value))| {
        let (rule, mut hint) = unknown(name, &known);
        if !matches!(value, Toml::Table(_))
            && let Some(home) = outermost().find(|section| section.key(name).is_some())
        {
            hint = Some(format!("`{name}` is a key of [{}]", home.name));
        }
        let problem = Problem { hint, ..Problem::new(format!("no such section; {rule}")) };
        problem.at(position.clone(), name)
    });
}
