//! Infer: reflectance maps become materials.

use std::path::{Path, PathBuf};

use serde::Serialize;

use super::light::SceneLight;
use super::shards::Inferred;
use super::{Choice, Fault};
use crate::base::Result;
use crate::flow::{Map, Outlet, Reservation};
use crate::model::{BUILT_IN, Backend, Estimate, Estimator, ModelSource, Session};
use crate::scene::Material;
use crate::scene::evidence::{Evidence, Filled};
use crate::scene::light::LocalLight;
use crate::scene::reflectance::SparseMap;
use crate::shard::rows::Row;
use crate::shard::{ShardMaps, ShardRows};

/// Section `[infer]`.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub struct Config {
    /// What turns a map into a material.
    pub estimator: Kind,
    /// The network.
    pub model: Model,
    /// What runs it.
    pub backend: Backend,
    /// The ONNX Runtime library to load, in place of `ORT_DYLIB_PATH` and the loader's own path.
    pub library: Option<PathBuf>,
    /// Maps that the estimator is given at once, 1 to 4,096: it takes those of like size together. The result does not
    /// depend on it.
    pub batch: u32,
}

/// What turns a map into a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default, Serialize)]
#[serde(rename_all = "lowercase")]
pub enum Kind {
    /// The network.
    #[default]
    Network,
    /// Least squares in the known light.
    Fit,
    /// The same from what the network says.
    #[serde(rename = "network+fit")]
    NetworkAndFit,
}

impl Kind {
    /// Whether it asks a network.
    pub fn has_network(self) -> bool {
        self != Kind::Fit
    }
}

impl Choice for Kind {
    const NAMES: &'static [(&'static str, Self)] =
        &[("network", Kind::Network), ("fit", Kind::Fit), ("network+fit", Kind::NetworkAndFit)];
}

/// The network that infers.
#[derive(Debug, Clone, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Model {
    /// One that gonio brings along, by name; one of [`BUILT_IN`].
    BuiltIn(String),
    /// An ONNX file that keeps the model contract.
    File(PathBuf),
}

impl Choice for Backend {
    const NAMES: &'static [(&'static str, Self)] = &Backend::NAMES;
}

impl Model {
    /// The network that is shipped inside gonio and used unless another is named.
    pub fn built_in() -> Model {
        Model::BuiltIn(BUILT_IN[0].name.to_owned())
    }

    /// Where its bytes come from.
    pub fn source(&self) -> ModelSource {
        match self {
            Model::BuiltIn(name) => ModelSource::named(name, Path::new("")),
            Model::File(path) => ModelSource::File(path.clone()),
        }
    }
}

impl Default for Config {
    fn default() -> Self {
        Config {
            estimator: Kind::Network,
            model: Model::built_in(),
            backend: Backend::Auto,
            library: None,
            batch: 4096,
        }
    }
}

impl Config {
    /// What is wrong with it. Whether the model keeps its contract is found out when it is opened.
    pub fn check(&self) -> Vec<Fault> {
        let mut faults: Vec<Fault> = Fault::unless_within("batch", self.batch, 1..=4096).into_iter().collect();
        if let Model::BuiltIn(name) = &self.model
            && !BUILT_IN.iter().any(|m| m.name == name)
        {
            let names: Vec<&str> = BUILT_IN.iter().map(|m| m.name).collect();
            let rule = format!("must be a file that ends in .onnx, or one of {}", names.join(", "));
            faults.push(Fault::new("model", rule, format!("{name:?}")));
        }
        if self.backend == Backend::Embedded
            && let Some(library) = &self.library
        {
            let rule = "has no meaning where backend = \"embedded\"";
            let hint = "take it out, or set backend = \"onnxruntime\"";
            faults.push(Fault::new("library", rule, library.display()).hint(hint));
        }
        faults
    }
}

/// Turns the maps of a shard, or of a part of one, into materials.
pub struct Infer<'a> {
    /// The network.
    pub estimator: &'a dyn Estimator,
    /// The light of the triangles, for an estimator that wants to know it.
    pub light: Option<SceneLight<'a>>,
    /// Filled bins that a triangle needs for a material of its own.
    pub min_bins: usize,
    /// Maps that the estimator is given at once: the more, the fuller its micro-batches.
    pub batch: usize,
}

/// What a worker keeps from shard to shard.
pub struct Scratch {
    session: Box<dyn Session>,
    answers: Vec<Estimate>,
}

impl Map for Infer<'_> {
    type In = (ShardMaps, Reservation);
    type Out = Inferred;
    type Scratch = Scratch;

    fn scratch(&self) -> Result<Scratch> {
        Ok(Scratch { session: self.estimator.session()?, answers: Vec::new() })
    }

    fn apply(
        &self,
        scratch: &mut Scratch,
        (shard, memory): (ShardMaps, Reservation),
        out: &mut Outlet<'_, Inferred>,
    ) -> Result<()> {
        let enough = |map: &SparseMap| map.bins.len() >= self.min_bins.max(1);
        let mut rows: Vec<Row> = Vec::with_capacity(shard.triangles.len());
        for (triangle, frames, map) in &shard.triangles {
            let filled = if enough(map) { Filled::Observed } else { Filled::Nothing };
            rows.push((*triangle, [f32::NAN; Material::LEN], Evidence { filled, ..Evidence::of(map, *frames) }));
        }
        let asked: Vec<(usize, &SparseMap)> =
            shard.triangles.iter().map(|t| &t.2).enumerate().filter(|(_, map)| enough(map)).collect();
        for batch in asked.chunks(self.batch.max(1)) {
            let maps: Vec<&SparseMap> = batch.iter().map(|(_, map)| *map).collect();
            scratch.answers.resize(maps.len(), Estimate::default());
            let local = |light: &SceneLight<'_>| -> Vec<LocalLight> {
                batch.iter().map(|(slot, _)| light.local(rows[*slot].0)).collect()
            };
            let lights = self.light.as_ref().map(local);
            scratch.session.estimate(&maps, lights.as_deref(), &mut scratch.answers)?;
            for ((slot, _), answer) in batch.iter().zip(&scratch.answers) {
                let (_, material, evidence) = &mut rows[*slot];
                (*material, evidence.deviation) = (answer.material.to_array(), answer.deviation);
            }
        }
        let (number, more) = (shard.shard, shard.more);
        // What waits for its turn is the rows alone.
        drop(asked);
        drop((shard, memory));
        out.send(Inferred { rows: ShardRows { shard: number, rows }, more })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn faults_are_found_together() {
        assert_eq!(Config::default().check(), []);
        let config = Config {
            estimator: Kind::Network,
            model: Model::BuiltIn("gonio-lobe-smal".into()),
            backend: Backend::Embedded,
            library: Some("libonnxruntime.so".into()),
            batch: 0,
        };
        assert_eq!(config.check().iter().map(|f| f.key).collect::<Vec<_>>(), ["batch", "model", "library"]);
        let file = Config { model: Model::File("any.onnx".into()), ..Config::default() };
        assert_eq!(file.check(), []);
    }
}
