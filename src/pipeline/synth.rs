//! Section `[synth]`: a scene with a known truth.

use std::path::PathBuf;

use crate::config::{Effect, Key, Keys, Leads, Section, Settings, Value};
use crate::synth::city::CityConfig;

/// Section `[synth]`: a scene with a known truth, made where it is missing.
#[derive(Debug, Clone, PartialEq)]
pub struct Synth {
    /// The folder that the scene is made in. [`MESH`], [`IMAGES`] and [`MODEL`] are in it then.
    pub into: PathBuf,
    /// The city that is made.
    pub city: CityConfig,
}

/// The mesh in the folder of a scene that was made.
pub(super) const MESH: &str = "mesh.ply";
/// The photographs in the folder of a scene that was made.
pub(super) const IMAGES: &str = "images";
/// The COLMAP model in the folder of a scene that was made.
pub(super) const MODEL: &str = "sparse/0";

impl Synth {
    /// The keys that may lead to what is made, each with its path.
    pub fn makes(&self) -> [(&'static str, PathBuf); 3] {
        [("scene.mesh", MESH), ("scene.images", IMAGES), ("scene.poses.path", MODEL)]
            .map(|(field, name)| (field, self.into.join(name)))
    }
}

impl Section for Synth {
    const NAME: &'static str = "synth";
    const ABOUT: &'static str = "A scene with a known truth, made on the first run.";
    const KEYS: &'static [Key] = &[
        Key { name: "into", doc: "The folder that the scene is made in.", value: Value::Needed("\"work/city\"") },
        Key { name: "city", doc: "The city that is made.", value: Value::Section },
    ];

    fn read(keys: &Keys<'_>) -> Self {
        let into = keys.path("into", Leads::to_folder_or_nothing("name a folder for the scene that is made"));
        Synth { into, city: CityConfig::read(&keys.section("city", CityConfig::OUTLINE)) }
    }

    fn settings(&self) -> Settings {
        let Synth { into, city } = self;
        Settings::of(Self::NAME).with("into", into, Effect::Nothing).and(city.settings())
    }
}
