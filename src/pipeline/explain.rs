//! What the next run would do again, and which input or setting is the cause.

use std::collections::{BTreeMap, BTreeSet};
use std::sync::Arc;

use super::exec::estimator;
use super::readable::Readable;
use super::resume::{self, IMAGE, MASK, POSE, TOO_LARGE, UNREADABLE, frames_of};
use super::scene::Loaded;
use super::{Pipeline, plan, shards};
use crate::base::Result;
use crate::disk::{DirStore, Manifest, Recipe, Unit};
use crate::stages::export::EXPORT;
use crate::stages::gather::FRAMES;
use crate::stages::merge::TABLES;
use crate::stages::shards::SHARD;

/// What the next run would do again, part by part of the run, in order.
#[derive(Debug, Clone, PartialEq, Eq, Default)]
pub struct Explanation {
    /// Frames, shards, tables, exports.
    pub parts: Vec<Part>,
}

/// One kind of work.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Part {
    /// What is counted: "frames".
    pub name: &'static str,
    /// How many there are; 0 where that is not known before frames are cast.
    pub total: usize,
    /// How many of them are done again, or for the first time.
    pub again: usize,
    /// Whether there may be more, which is known once the frames are cast.
    pub at_least: bool,
    /// Why, in words, each once.
    pub causes: Vec<String>,
}

impl Explanation {
    /// Whether the next run has nothing to do.
    pub fn is_nothing(&self) -> bool {
        self.parts.iter().all(|part| part.again == 0 && !part.at_least)
    }
}

/// Compares what the pipeline is made of now with what the manifest says was done. Changes nothing.
///
/// # Errors
/// Inputs, a model or a manifest that cannot be read.
pub fn explain(pipeline: &Pipeline) -> Result<Explanation> {
    let store = DirStore::new(&pipeline.run.work);
    let manifest = Manifest::read(Arc::new(store.clone()))?;
    let estimator = estimator(pipeline)?;
    let base = plan::base();
    let loaded = Loaded::expected(pipeline)?;
    let fit = Readable::of(pipeline, &loaded, base);
    let groups = resume::groups(pipeline, &manifest, loaded.mesh_key, &loaded.frames, Some(&fit));
    let units: BTreeSet<String> = groups.iter().map(|group| group.recipe.unit()).collect();
    let stale: Vec<&Unit> =
        manifest.of_kind(FRAMES).filter(|(name, _)| !units.contains(*name)).map(|(_, unit)| unit).collect();
    let to_do = resume::to_do(&manifest, &groups);

    let mut causes = Vec::new();
    for group in &to_do {
        let ours: BTreeSet<&str> = frames_of(&group.recipe).collect();
        let before: Vec<&Recipe> =
            stale.iter().map(|unit| &unit.recipe).filter(|r| frames_of(r).any(|name| ours.contains(name))).collect();
        causes.extend(reasons(&group.recipe, &before));
    }
    let gone = stale.iter().flat_map(|unit| frames_of(&unit.recipe)).filter(|name| loaded.frame(name).is_err());
    causes.extend(gone.map(|name| format!("{name} is no longer among the poses")));
    let frames = Part {
        name: "frames",
        total: loaded.frames.len(),
        again: to_do.iter().map(|group| group.frames.len()).sum(),
        at_least: false,
        causes: each_once(causes),
    };

    let all = shards::of_groups(pipeline, &*estimator, &store, &manifest, &groups, &loaded)?;
    let done: BTreeMap<&str, &Recipe> =
        manifest.of_kind(SHARD).map(|(_, unit)| (unit.recipe.what(), &unit.recipe)).collect();
    let changed: Vec<_> = all.iter().filter(|shard| manifest.files(&shard.recipe.unit()).is_none()).collect();
    let causes = changed.iter().flat_map(|shard| match done.get(shard.recipe.what()) {
        Some(before) => reasons(&shard.recipe, &[before]),
        None => vec!["seen for the first time".to_owned()],
    });
    let mut causes = each_once(causes);
    if frames.again > 0 {
        causes.push("all that the frames above see".to_owned());
    }
    let shards = Part {
        name: "shards",
        total: if frames.again > 0 { 0 } else { all.len() },
        again: changed.len(),
        at_least: frames.again > 0,
        causes,
    };

    let recipe = shards::tables(pipeline, loaded.mesh_key, &all);
    let open = shards.again > 0 || shards.at_least;
    let tables = one_by_one("tables", TABLES, &manifest, std::slice::from_ref(&recipe), open);
    let exports: Vec<Recipe> = pipeline.export.formats.iter().map(|&f| pipeline.export.recipe(f, &recipe)).collect();
    let exports = one_by_one("exports", EXPORT, &manifest, &exports, tables.again > 0);
    Ok(Explanation { parts: vec![frames, shards, tables, exports] })
}

/// Units that are found by what they are. If `open`, what comes before them is done again, and so are all of them.
fn one_by_one(name: &'static str, kind: &str, manifest: &Manifest, wanted: &[Recipe], open: bool) -> Part {
    let again: Vec<&Recipe> = wanted.iter().filter(|recipe| open || manifest.files(&recipe.unit()).is_none()).collect();
    let before: Vec<&Recipe> = manifest.of_kind(kind).map(|(_, unit)| &unit.recipe).collect();
    let causes = again.iter().flat_map(|recipe| {
        let before: Vec<&Recipe> = before.iter().copied().filter(|r| r.what() == recipe.what()).collect();
        let made_of_the_above = |reason: &String| reason == "shards changed" || reason == "tables changed";
        let mut reasons = reasons(recipe, &before);
        reasons.retain(|reason| !made_of_the_above(reason));
        if open {
            reasons.push("made of what is done again above".to_owned());
        }
        reasons
    });
    Part { name, total: wanted.len(), again: again.len(), at_least: false, causes: each_once(causes) }
}

/// How a unit differs from those that were done in its place.
fn reasons(now: &Recipe, before: &[&Recipe]) -> Vec<String> {
    let new = |part: &str| before.iter().all(|recipe| recipe.part(part).is_none());
    if before.is_empty() {
        let frames: Vec<String> = frames_of(now).map(|name| format!("{name} is new")).collect();
        return if frames.is_empty() { vec!["not done yet".to_owned()] } else { frames };
    }
    let mut reasons = Vec::new();
    for recipe in before {
        for (part, old, value) in now.differences(recipe) {
            let frame = [IMAGE, MASK, POSE].iter().find_map(|kind| Some((*kind, part.strip_prefix(kind)?)));
            match frame {
                // A frame of another group, or one that is no longer there, which the caller tells.
                Some((_, name)) if now.part(&format!("{POSE}{name}")).is_none() => {}
                Some((_, name)) if new(&format!("{POSE}{name}")) => reasons.push(format!("{name} is new")),
                Some((_, name)) if recipe.part(&format!("{POSE}{name}")).is_none() => {}
                Some((kind, name)) => reasons.push(of_frame(kind, name, old, value)),
                None => reasons.push(of_setting(part, old, value)),
            }
        }
    }
    reasons
}

fn of_frame(kind: &str, name: &str, before: Option<&str>, now: Option<&str>) -> String {
    let kind = kind.trim_end();
    match (before, now) {
        (None, _) => format!("{name} has a {kind} now"),
        (_, None) => format!("{name} has no {kind} any more"),
        (Some(TOO_LARGE), Some(now)) if now != UNREADABLE => format!("{name} fits under [run] memory now"),
        (_, Some(TOO_LARGE)) => format!("{name} does not fit under [run] memory any more"),
        (Some(UNREADABLE), _) => format!("the {kind} of {name} can be read now"),
        (_, Some(UNREADABLE)) => format!("the {kind} of {name} can no longer be read"),
        _ => format!("the {kind} of {name} changed"),
    }
}

fn of_setting(part: &str, before: Option<&str>, now: Option<&str>) -> String {
    let is_key = |value: &str| value.len() == 64 && value.bytes().all(|b| b.is_ascii_hexdigit());
    match (part, before, now) {
        ("format", ..) => "this gonio writes another format".to_owned(),
        (_, Some(before), Some(now)) if !is_key(now) && before.len() + now.len() < 80 => {
            format!("{part} was {before} and is {now}")
        }
        _ => format!("{part} changed"),
    }
}

fn each_once(words: impl IntoIterator<Item = String>) -> Vec<String> {
    let mut seen = BTreeSet::new();
    words.into_iter().filter(|word| seen.insert(word.clone())).collect()
}
