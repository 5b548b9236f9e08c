//! Whether a run's folder is as it was written, and the inputs as they were when something was made of them. Nothing is changed.

use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;
use std::sync::Arc;

use crate::base::{Error, Result};
use crate::codec::images::mask_path;
use crate::disk::{DirStore, Held, Ledger, Recipe, Rotten, Store, UnitName, mark, verify as verify_units};
use crate::flow::pool;
use crate::phases::{
    Cause, FrameChange, FrameInput, Known, Look, PHASES, Phase, REPORT, Report, UnitCount, read_report,
};
use crate::pipeline::Pipeline;

/// What was found of a run's folder, and of its inputs if they were asked for.
#[derive(Debug)]
pub(crate) struct Verified {
    /// What was held against its record, and what is rotten.
    pub held: Held,
    /// Whether the run is finished; else the same command goes on with it.
    pub finished: bool,
    /// The inputs that are no longer those that something was made of.
    pub changed: Vec<Changed>,
    /// Why inputs could not be compared.
    pub unread: Vec<Error>,
}

/// An input that is no longer the one that something was made of.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(crate) struct Changed {
    /// The file or folder, or the key that names the input.
    pub input: PathBuf,
    /// How the input changed.
    pub cause: Cause,
    /// The unit that was made of it, as "cast 17".
    pub unit: String,
}

impl Verified {
    /// Whether run and inputs are as they were.
    pub(crate) fn is_sound(&self) -> bool {
        self.held.rotten.is_empty() && self.changed.is_empty() && self.unread.is_empty()
    }
}

/// Holds every file of a pipeline's run against its record and, if asked, every input against the recipes of what was made of it.
///
/// # Errors
/// There is no run; the store fails.
pub(crate) fn verify(pipeline: &Pipeline, inputs: bool) -> Result<Verified> {
    let store: Arc<dyn Store> = Arc::new(DirStore::new(&pipeline.run.work));
    if store.size(mark::MARK)?.is_none() {
        let (work, file) = (pipeline.run.work.display(), pipeline.file.display());
        return Err(Error::invalid(format!("{work} holds no run: `gonio run {file}` makes one")));
    }
    verify_phases(PHASES, &store, pipeline, inputs)
}

pub(super) fn verify_phases(
    phases: &[&dyn Phase],
    store: &Arc<dyn Store>,
    pipeline: &Pipeline,
    inputs: bool,
) -> Result<Verified> {
    let before = report(&**store)?;
    let (ledger, findings) = pool::share(pipeline.run.threads(), || Ledger::read(Arc::clone(store)))??;
    // A run that goes on meanwhile removes the report, and writes another when it ends.
    let report = report(&**store)?.filter(|report| before.as_ref() == Some(report));
    let mut held = verify_units(&**store, &ledger, &findings)?;
    for phase in phases {
        held.rotten.extend(phase.rotten(store, &ledger)?);
    }
    match &report {
        Some(Err(rotten)) => held.rotten.push(rotten.clone()),
        Some(Ok(report)) if held.rotten.is_empty() => held.rotten.extend(missing(phases, report, &ledger)),
        Some(Ok(_)) | None => {}
    }
    let mut verified = Verified { held, finished: report.is_some(), changed: Vec::new(), unread: Vec::new() };
    if inputs {
        verified.compare_inputs(phases, store, &ledger, pipeline);
    }
    Ok(verified)
}

/// The report of a finished run, or what is wrong with it.
fn report(store: &dyn Store) -> Result<Option<Result<Report, Rotten>>> {
    if store.is_obstructed(REPORT)? {
        let why = Error::invalid("is no file, but a folder, a link or a device");
        return Ok(Some(Err(Rotten::new(REPORT, &why))));
    }
    Ok(match read_report(store) {
        Ok(found) => found.map(Ok),
        Err(why) => Some(Err(Rotten::new(REPORT, &why))),
    })
}

/// The unit records that a finished run left and that are gone.
fn missing(phases: &[&dyn Phase], report: &Report, ledger: &Ledger) -> Vec<Rotten> {
    let now = UnitCount::of(phases.iter().map(|phase| phase.name()), ledger);
    let count = |phase| now.iter().find(|found| found.phase == phase).map_or(0, |found| found.count);
    let gone = report.units.iter().filter(|then| !now.contains(then));
    gone.map(|then| Rotten {
        file: "units".to_owned(),
        unit: Some(format!("units of {}", then.phase)),
        why: format!("the run left {} unit records of {}, and {} are there", then.count, then.phase, count(then.phase)),
    })
    .collect()
}

impl Verified {
    /// Compares the recipes that the inputs have now with those of the units that are done.
    fn compare_inputs(&mut self, phases: &[&dyn Phase], store: &Arc<dyn Store>, ledger: &Ledger, pipeline: &Pipeline) {
        let mut known = match Known::new(pipeline) {
            Ok(known) => known,
            Err(why) => return self.unread.push(why),
        };
        if let Err(why) = known.look(Look::Explain, store, ledger, &|_, _| Ok(())) {
            return self.unread.push(why);
        }
        let mut found: BTreeMap<Cause, String> = BTreeMap::new();
        for phase in phases {
            if let Err(why) = changed(*phase, &known, store, ledger, &mut found) {
                // What is rotten of the run's own files has been told.
                let told = |rotten: &Rotten| why.malformed_file() == Some(&store.path(&rotten.file));
                if !self.held.rotten.iter().any(told) {
                    self.unread.push(why);
                }
            }
        }
        let changed = |(cause, unit): (Cause, String)| Changed { input: place(&cause, pipeline), cause, unit };
        self.changed = found.into_iter().map(changed).collect();
    }
}

/// Notes which inputs of a phase's units changed, each with the first unit that was made of it.
fn changed(
    phase: &dyn Phase,
    known: &Known<'_>,
    store: &Arc<dyn Store>,
    ledger: &Ledger,
    found: &mut BTreeMap<Cause, String>,
) -> Result<()> {
    let recipes = |units: Vec<UnitName>| units.iter().map(|unit| ledger.recipe(unit)).collect::<Result<Vec<_>>>();
    let mut note = |cause: Cause, recipe: &Recipe| {
        found.entry(cause).or_insert_with(|| recipe.in_words());
    };
    let units = phase.units(known, &**store, ledger)?;
    for unit in units.all.iter().filter(|unit| !ledger.is_done(&unit.name)) {
        let before = recipes(ledger.find(phase.name(), unit.recipe.what()))?;
        for cause in phase.causes(Some(&unit.recipe), &before) {
            if is_input(&cause, &unit.recipe, &before) {
                note(cause, &unit.recipe);
            }
        }
    }
    let wanted: BTreeSet<&str> = units.all.iter().map(|unit| unit.recipe.what()).collect();
    let is_gone = |unit: &UnitName| ledger.what(unit).is_some_and(|what| !wanted.contains(&*what));
    for recipe in recipes(ledger.of_phase(phase.name()).into_iter().filter(is_gone).collect())? {
        phase.causes(None, std::slice::from_ref(&recipe)).into_iter().for_each(|cause| note(cause, &recipe));
    }
    Ok(())
}

/// Whether a cause is that an input is not what it was.
fn is_input(cause: &Cause, now: &Recipe, before: &[Recipe]) -> bool {
    match cause {
        Cause::Frame { input: FrameInput::Gain, .. } => false,
        Cause::Frame { change, .. } => {
            use FrameChange::{Came, Content, Unreadable, Went};
            matches!(change, Content | Unreadable | Went | Came)
        }
        Cause::FrameGone { .. } => true,
        // By another setting, an input may have come to matter, or another one may have been chosen.
        Cause::Input { key } => {
            let has = |recipe: &Recipe| recipe.ingredient(key).is_some();
            let chosen = |recipe: &Recipe| recipe.ingredient("infer.estimator") == now.ingredient("infer.estimator");
            has(now) && before.iter().any(|recipe| has(recipe) && chosen(recipe))
        }
        _ => false,
    }
}

/// The file of an input, or the key that names it.
fn place(cause: &Cause, pipeline: &Pipeline) -> PathBuf {
    let scene = &pipeline.scene;
    match cause {
        Cause::Frame { frame, input: FrameInput::Image, .. } => scene.images.join(frame),
        Cause::Frame { frame, input: FrameInput::Mask, .. } => {
            let masks = scene.masks.clone().unwrap_or_default();
            mask_path(&masks, &scene.images, frame)
                .ok()
                .flatten()
                .unwrap_or_else(|| masks.join(frame).with_extension("png"))
        }
        Cause::Frame { .. } | Cause::FrameGone { .. } => scene.poses.path.clone(),
        Cause::Input { key } if key == "scene.mesh" => scene.mesh.first().to_owned(),
        Cause::Input { key } => PathBuf::from(key),
        _ => PathBuf::new(),
    }
}
