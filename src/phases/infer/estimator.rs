//! The estimator of a pipeline: loaded, and tried.

use std::collections::BTreeSet;
use std::time::Instant;

use glam::Vec3;

use crate::base::{Error, Result, memory};
use crate::config::Choice;
use crate::model::{self, Estimate, Estimator, Fit};
use crate::phases::facts::USUAL_BINS;
use crate::pipeline::Pipeline;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{Bin, BinSum, FRONT_BINS, Layout, SparseMap};
use crate::stages::{infer, light};

/// Loads the estimator, for a scene with a light or without one. A network must take what scenes give.
///
/// # Errors
/// A model or a library that cannot be used, a network that wants a light which is not known.
pub(crate) fn load_estimator(pipeline: &Pipeline, lit: bool) -> Result<Box<dyn Estimator>> {
    let method = pipeline.infer.estimator.settled(lit);
    let network = method.has_network().then(|| load_network(pipeline)).transpose()?;
    Ok(match network {
        Some(network) if method == infer::Method::Network => network,
        network => Box::new(Fit::new(network)),
    })
}

fn load_network(pipeline: &Pipeline) -> Result<Box<dyn Estimator>> {
    let config = &pipeline.infer;
    let network = model::load(&config.model.source(), config.backend, config.library.as_deref())?;
    network.contract().require(Layout::Lobe)?;
    if network.contract().light.wanted() && pipeline.light.mode != light::Mode::Known {
        return Err(Error::invalid(format!(
            "{} needs a known light, and [light] mode is \"{}\": set [light] mode = \"known\", or choose a model without \
             a `light` input",
            network.describe(),
            pipeline.light.mode.name()
        )));
    }
    Ok(network)
}

/// What a try of an estimator found.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct TriedEstimator {
    /// Seconds that one map takes one worker.
    pub seconds_per_map: f64,
    /// Bytes that a worker's session holds.
    pub session: u64,
}

/// The maps of a trial.
const TRIED: usize = 16;

impl TriedEstimator {
    /// Tries an estimator: one batch of maps to warm up, then one by the clock.
    ///
    /// # Errors
    /// What the estimator says when it refuses.
    pub(crate) fn of(estimator: &dyn Estimator) -> Result<Self> {
        let usual = |n: usize| -> BTreeSet<Bin> {
            (0..USUAL_BINS).filter_map(|i| Bin::try_from((n * 37 + i * 211) % FRONT_BINS).ok()).collect()
        };
        let seen = BinSum::one([0.5; 3], false);
        let map = |n: usize| SparseMap { bins: usual(n).into_iter().map(|bin| (bin, seen)).collect() };
        let maps: Vec<SparseMap> = (0..TRIED.next_multiple_of(estimator.micro_batch())).map(map).collect();
        let maps: Vec<&SparseMap> = maps.iter().collect();
        let before = memory::resident().unwrap_or(0);
        let mut session = estimator.session()?;
        let mut answers = vec![Estimate::default(); maps.len()];
        let light = LocalLight { direction: Vec3::Z, sun: Vec3::ONE, sky: Vec3::ZERO };
        let lights = vec![light.into(); maps.len()];
        let lights = estimator.contract().light.wanted().then_some(lights.as_slice());
        session.estimate(&maps, lights, &mut answers)?;
        let started = Instant::now();
        session.estimate(&maps, lights, &mut answers)?;
        let seconds_per_map = started.elapsed().as_secs_f64() / maps.len() as f64;
        // The session is there still: what the process has grown by is the session's.
        let grown = memory::resident().unwrap_or(0).saturating_sub(before);
        drop(session);
        Ok(TriedEstimator { seconds_per_map, session: (estimator.memory(1).0 - estimator.memory(0).0).max(grown) })
    }
}
