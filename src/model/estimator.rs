//! The estimator: reflectance maps in, materials out.

use super::contract::Contract;
use crate::base::Result;
use crate::base::key::Key;
use crate::base::units::Bytes;
use crate::scene::Material;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::SparseMap;

/// The light that the observations of a map were made in.
#[derive(Debug, Clone, Copy)]
pub struct MapLight<'a> {
    /// The light of the triangle, in the mean over all observations.
    pub whole: LocalLight,
    /// The observations apart, each with the light of its own; empty where all were made in `whole`.
    pub parts: &'a [(&'a SparseMap, LocalLight)],
}

impl From<LocalLight> for MapLight<'_> {
    fn from(whole: LocalLight) -> Self {
        MapLight { whole, parts: &[] }
    }
}

/// Turns reflectance maps into materials. All workers share an estimator; each makes its own `Session`.
pub trait Estimator: Send + Sync {
    /// The contract that the estimator keeps.
    fn contract(&self) -> &Contract;

    /// The model, the engine, its version and its library, in one line for the log.
    fn describe(&self) -> String;

    /// The key of the model's bytes. The same model on the same engine gives equal materials for equal maps.
    fn key(&self) -> Key;

    /// The engine and its version.
    fn engine(&self) -> String;

    /// The most maps that go through the engine at once. A multiple of this number wastes least.
    fn micro_batch(&self) -> usize;

    /// The bytes that the estimator and this many sessions will hold, estimated from the model's size.
    fn memory(&self, sessions: usize) -> Bytes;

    /// Makes a session for one worker.
    ///
    /// # Errors
    /// The engine's own words, if it refuses.
    fn session(&self) -> Result<Box<dyn Session>>;
}

/// One worker's use of an estimator.
pub trait Session: Send {
    /// Estimates the material of each map. `out` is as long as `maps`.
    ///
    /// `lights` holds the light of each map's triangle; it is given if and only if the contract asks for it. Components come
    /// out in [0, 1].
    ///
    /// # Errors
    /// Lengths that differ, an engine that fails, or a component that is not a number or lies outside [0, 1] by more than 1e-4.
    fn estimate(&mut self, maps: &[&SparseMap], lights: Option<&[MapLight<'_>]>, out: &mut [Estimate]) -> Result<()>;
}

/// The estimate of one triangle's material.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Estimate {
    /// The material.
    pub material: Material,
    /// The standard deviations of the material's components, in the order of [`Material::NAMES`]; NaN if the estimator gives
    /// none.
    pub deviation: [f32; Material::LEN],
}

impl Default for Estimate {
    fn default() -> Self {
        Estimate { material: Material::default(), deviation: [f32::NAN; Material::LEN] }
    }
}
