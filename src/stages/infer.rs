//! Infer: reflectance maps become materials.

use std::path::{Path, PathBuf};

use glam::Vec3;

use super::light;
use super::scene_light::{AllReaching, SceneLights};
use super::shards::Inferred;
use crate::base::Result;
use crate::config::{Choice, Effect, Key, Keys, Leads, Problem, Section, Settings, Value};
use crate::flow::{Map, Outlet, Reservation};
use crate::model::{BUILT_IN, Backend, Estimate, Estimator, MapLight, ModelSource, Session};
use crate::scene::Material;
use crate::scene::cells::Apart;
use crate::scene::evidence::{Evidence, Filled};
use crate::scene::reflectance::{FRONT_BINS, SparseMap};
use crate::shard::{Row, ShardMaps, ShardRows, TriangleMap};

/// Section `[infer]`.
#[derive(Debug, Clone, PartialEq)]
pub struct Config {
    /// The method that turns a map into a material.
    pub estimator: Method,
    /// The network.
    pub model: Model,
    /// The engine that runs the network.
    pub backend: Backend,
    /// The ONNX Runtime library to load, in place of `ORT_DYLIB_PATH` and the loader's own path.
    pub library: Option<PathBuf>,
    /// Maps that the estimator is given at once, 1 to 4,096: it takes maps of like size together. The result does not depend
    /// on it.
    pub batch: u32,
    /// Bins that a triangle's map must have filled for its material to count, 1 to 3,600.
    pub min_bins: usize,
}

/// A method that turns a map into a material.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Method {
    /// [`Method::NetworkAndFit`] where there is a light, else [`Method::Network`].
    Auto,
    /// The network.
    Network,
    /// Least squares in the light.
    Fit,
    /// Least squares that start from the network's answer.
    NetworkAndFit,
}

impl Method {
    /// Whether the method asks a network.
    pub fn has_network(self) -> bool {
        self != Method::Fit
    }

    /// The method where there is a light, or none.
    #[must_use]
    pub fn settled(self, lit: bool) -> Method {
        match (self, lit) {
            (Method::Auto, true) => Method::NetworkAndFit,
            (Method::Auto, false) => Method::Network,
            (method, _) => method,
        }
    }
}

impl Choice for Method {
    const NAMES: &'static [(&'static str, Self)] = &[
        ("auto", Method::Auto),
        ("network", Method::Network),
        ("fit", Method::Fit),
        ("network+fit", Method::NetworkAndFit),
    ];
}

/// The network that infers.
#[derive(Debug, Clone, PartialEq, Eq)]
pub enum Model {
    /// One of [`BUILT_IN`], by name.
    BuiltIn(String),
    /// An ONNX file that keeps the model contract.
    File(PathBuf),
}

impl Choice for Backend {
    const NAMES: &'static [(&'static str, Self)] = &Backend::NAMES;
}

impl Model {
    /// The network that is used unless another is named.
    pub fn built_in() -> Model {
        Model::BuiltIn(BUILT_IN[0].name.to_owned())
    }

    /// The source of the network's bytes.
    pub fn source(&self) -> ModelSource {
        match self {
            Model::BuiltIn(name) => ModelSource::named(name, Path::new("")),
            Model::File(path) => ModelSource::File(path.clone()),
        }
    }

    fn read(keys: &Keys<'_>) -> Model {
        let name: String = keys.value("model");
        if name.to_ascii_lowercase().ends_with(".onnx") {
            let leads = Leads::to_file("name an ONNX file, or a model that gonio brings along");
            return keys.optional_path("model", leads).map_or_else(Model::built_in, Model::File);
        }
        let known: Vec<&str> = BUILT_IN.iter().map(|model| model.name).collect();
        let rule = format!("must be a file that ends in .onnx, or one of {}", known.join(", "));
        keys.check("model", known.contains(&name.as_str()), rule);
        Model::BuiltIn(name)
    }

    fn name(&self) -> &Path {
        match self {
            Model::BuiltIn(name) => Path::new(name),
            Model::File(path) => path,
        }
    }
}

impl Section for Config {
    const NAME: &'static str = "infer";
    const ABOUT: &'static str = "How reflectance maps become materials.";
    const KEYS: &'static [Key] = &[
        Key {
            name: "estimator",
            doc: "What turns a reflectance map into a material: \"network\"; or, where there is a light (see [light]), \"fit\", or \
                  \"network+fit\", which starts from the network's answer; \"auto\" is \"network+fit\" where there is a light, \
                  else \"network\".",
            value: Value::Default("\"auto\""),
        },
        Key {
            name: "model",
            doc: "The network: \"gonio-lobe-small\", which gonio brings along, or an ONNX file that keeps the model contract.",
            value: Value::Default("\"gonio-lobe-small\""),
        },
        Key {
            name: "backend",
            doc: "The engine that runs the network: \"embedded\", which needs nothing installed; \"onnxruntime\", a faster \
                  library that you install; \"auto\" takes the library where there is one.",
            value: Value::Default("\"auto\""),
        },
        Key {
            name: "library",
            doc: "The ONNX Runtime library, where it is not on the loader's path nor in ORT_DYLIB_PATH.",
            value: Value::Optional("\"/usr/lib/libonnxruntime.so\""),
        },
        Key {
            name: "batch",
            doc: "Maps that the network is given at once, 1 to 4096. Fewer are slower; the result is the same.",
            value: Value::Default("4096"),
        },
        Key {
            name: "min_bins",
            doc: "Bins that a triangle's reflectance map must have filled, 1 to 3600. A triangle with fewer counts as not seen.",
            value: Value::Default("1"),
        },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let backend = keys.choice("backend");
        let leads = Leads::to_file("name the library file, as libonnxruntime.so, or take the key out");
        let library = keys.optional_path("library", leads);
        let idle = Problem::new("has no meaning where backend = \"embedded\"");
        let hint = "take it out, or set backend = \"onnxruntime\"";
        keys.check("library", library.is_none() || backend != Backend::Embedded, idle.hint(hint));
        Config {
            estimator: keys.choice("estimator"),
            model: Model::read(keys),
            backend,
            library,
            batch: keys.within("batch", 1..=4096),
            min_bins: keys.within("min_bins", 1..=FRONT_BINS),
        }
    }

    fn settings(&self) -> Settings {
        let Config { estimator, model, backend, library, batch, min_bins } = self;
        Settings::of(Self::NAME)
            .with("estimator", estimator.name(), Effect::Infer)
            .with("model", model.name(), Effect::Input)
            .with("backend", Choice::name(*backend), Effect::Input)
            .optional("library", library.as_ref(), Effect::Input)
            .with("batch", batch, Effect::Nothing)
            .with("min_bins", min_bins, Effect::Infer)
    }
}

impl Config {
    /// Checks that the estimator is told the light if it needs it.
    pub fn check_light(&self, light: &light::Config, keys: &Keys<'_>) {
        let problem = Problem::new("needs a light where it fits").got("an unknown one");
        let hint = "set [light] mode = \"estimate\", or \"known\" and its sun, or estimator = \"auto\"";
        let fits = matches!(self.estimator, Method::Fit | Method::NetworkAndFit);
        let good = !fits || light.mode != light::Mode::Unknown;
        keys.check("estimator", good, problem.hint(hint));
    }
}

/// Turns the maps of a shard, or of a slice of it, into materials.
pub(crate) struct Infer<'a> {
    /// The estimator.
    pub estimator: &'a dyn Estimator,
    /// The lights over the scene, for an estimator that is told them.
    pub lights: Option<SceneLights<'a>>,
    /// Filled bins that a triangle needs for a material of its own.
    pub min_bins: usize,
    /// Maps that the estimator is given at once. The more maps, the fuller its micro-batches.
    pub batch: usize,
}

/// A worker's session, kept from shard to shard.
pub(crate) struct Scratch {
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
        let (number, more) = (shard.shard, shard.more);
        let mut rows: Vec<Row> = Vec::with_capacity(shard.triangles.len());
        let mut maps: Vec<Apart> = Vec::with_capacity(shard.triangles.len());
        for TriangleMap { triangle, frames, cells } in shard.triangles {
            let apart = Apart::of(cells);
            let filled = if enough(&apart.whole) { Filled::Observed } else { Filled::Nothing };
            let evidence = Evidence { filled, ..Evidence::of(&apart.whole, frames) };
            rows.push(Row { triangle, material: [f32::NAN; Material::LEN], evidence });
            maps.push(apart);
        }
        let asked: Vec<(usize, &Apart)> = maps.iter().enumerate().filter(|(_, apart)| enough(&apart.whole)).collect();
        for batch in asked.chunks(self.batch.max(1)) {
            let whole: Vec<&SparseMap> = batch.iter().map(|(_, apart)| &apart.whole).collect();
            scratch.answers.resize(whole.len(), Estimate::default());
            let reaching = |lights: &SceneLights<'_>| -> Vec<AllReaching> {
                batch.iter().map(|(slot, _)| lights.reaching(rows[*slot].triangle)).collect()
            };
            let reaching = self.lights.as_ref().map(reaching);
            let both = || reaching.iter().flatten().zip(batch);
            let parts: Vec<Vec<_>> = both().map(|(reaching, (_, apart))| reaching.parts(apart).collect()).collect();
            let each = both().zip(&parts);
            let lights = each.map(|((reaching, (_, apart)), parts)| MapLight { whole: reaching.whole(apart), parts });
            let lights: Option<Vec<MapLight<'_>>> = self.lights.as_ref().map(|_| lights.collect());
            scratch.session.estimate(&whole, lights.as_deref(), &mut scratch.answers)?;
            for ((slot, _), answer) in batch.iter().zip(&scratch.answers) {
                let Row { material, evidence, .. } = &mut rows[*slot];
                (*material, evidence.deviation) = (answer.material.to_array(), answer.deviation);
            }
            for ((slot, apart), reaching) in batch.iter().zip(reaching.iter().flatten()) {
                let Row { material, evidence, .. } = &mut rows[*slot];
                evidence.lit = reaching.lit();
                widen(&mut evidence.deviation, material, reaching.doubt(apart));
            }
        }
        // Only the rows wait for their turn.
        drop(asked);
        drop((maps, memory));
        out.send(Inferred { rows: ShardRows { shard: number, rows }, more })
    }
}

/// Adds what the light's doubt makes of kd and ks, which are measured by it.
fn widen(deviation: &mut [f32; Material::LEN], material: &[f32; Material::LEN], doubt: Vec3) {
    for (at, (deviation, value)) in deviation.iter_mut().zip(material).take(6).enumerate() {
        *deviation = deviation.hypot(doubt[at % 3] * value);
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::config::{defaults, read_text};

    /// A file that is there.
    const THERE: &str = concat!(env!("CARGO_MANIFEST_DIR"), "/Cargo.toml");

    #[test]
    fn problems_are_found_together() {
        let fields = |text: &str| -> Vec<String> {
            read_text::<Config>(text).1.into_iter().map(|problem| problem.field).collect()
        };
        let text =
            format!("batch = 0\nmodel = 'gonio-lobe-smal'\nbackend = 'embedded'\nlibrary = '{THERE}'\nmin_bins = 0");
        assert_eq!(fields(&text), ["infer.batch", "infer.model", "infer.library", "infer.min_bins"]);
        assert_eq!(fields(&format!("backend = 'auto'\nlibrary = '{THERE}'\nmin_bins = 3600")), [""; 0]);
        assert_eq!(fields("model = 'nowhere.ONNX'\nmin_bins = 3601"), ["infer.model", "infer.min_bins"]);
    }

    #[test]
    fn the_default_model_is_the_built_in_one() {
        assert_eq!(defaults::<Config>().model, Model::built_in());
        let file = concat!(env!("CARGO_MANIFEST_DIR"), "/tests/data/models/conv4.onnx");
        let (config, problems) = read_text::<Config>(&format!("model = '{file}'"));
        assert_eq!((config.model, problems), (Model::File(file.into()), vec![]));
    }
}
