//! One worker's use of a network. Maps of one size go together, in micro-batches of a fixed count, the last filled up with
//! empty maps, so that the engine always does the same arithmetic in the same order.

use std::iter;

use glam::Vec3;

use super::contract::Contract;
use super::engine::{Batch, Engine};
use super::estimator::{Estimate, MapLight, Session};
use super::pack::least_size;
use crate::base::{Error, Result};
use crate::scene::Material;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::SparseMap;

/// The light beside an empty map.
pub(super) const OVERHEAD: LocalLight = LocalLight { direction: Vec3::Z, sun: Vec3::ONE, sky: Vec3::ZERO };

/// How far rounding may carry a component outside [0, 1].
const SLACK: f32 = 1e-4;

/// A session of a network on any engine.
pub(super) struct OnnxSession {
    contract: Contract,
    sizes: Vec<Size>,
    /// The values of one micro-batch.
    values: Vec<f32>,
    lights: Vec<f32>,
    mu: Vec<f32>,
    engine: Box<dyn Engine>,
}

/// A size of map.
struct Size {
    bins: usize,
    /// The number of maps that go through the engine at once.
    batch: usize,
    /// The shape of a micro-batch.
    shape: Vec<usize>,
}

impl OnnxSession {
    /// A session; `batches` holds the number of maps that go through the engine at once, for each size of the input.
    pub(super) fn new(contract: Contract, batches: Vec<usize>, engine: Box<dyn Engine>) -> OnnxSession {
        let sizes = contract.input.sizes().into_iter().zip(batches);
        let sizes = sizes.map(|(bins, batch)| Size { bins, batch, shape: contract.shape(batch, bins) }).collect();
        OnnxSession { contract, sizes, values: Vec::new(), lights: Vec::new(), mu: Vec::new(), engine }
    }
}

impl Session for OnnxSession {
    fn estimate(&mut self, maps: &[&SparseMap], lights: Option<&[MapLight<'_>]>, out: &mut [Estimate]) -> Result<()> {
        self.check(maps.len(), lights, out.len())?;
        let lights = lights.unwrap_or_default();
        let deviation = self.contract.deviation.unwrap_or([f32::NAN; Material::LEN]);
        let bins: Vec<usize> = self.sizes.iter().map(|size| size.bins).collect();
        let sizes: Vec<usize> = maps.iter().map(|map| least_size(&bins, map)).collect();
        for size in 0..bins.len() {
            let alike: Vec<usize> = (0..maps.len()).filter(|&i| sizes[i] == size).collect();
            for chosen in alike.chunks(self.sizes[size].batch) {
                self.run(size, chosen, maps, lights)?;
                for (&i, mu) in chosen.iter().zip(self.mu.chunks_exact(Material::LEN)) {
                    let fault = |found| Error::malformed(&self.contract.model, format!("map {i} of {found}"));
                    out[i] = Estimate { material: material(mu).map_err(fault)?, deviation };
                }
            }
        }
        Ok(())
    }
}

impl OnnxSession {
    /// Checks that each of `maps` maps has an answer, and a light if the model takes one.
    fn check(&self, maps: usize, lights: Option<&[MapLight<'_>]>, answers: usize) -> Result<()> {
        let wrong = |found: String| Err(Error::malformed(&self.contract.model, found));
        if maps != answers {
            return wrong(format!("{maps} maps came for {answers} materials"));
        }
        if lights.is_some() != self.contract.light.wanted() || lights.is_some_and(|l| l.len() != maps) {
            let needed = if self.contract.light.wanted() { "needs a light beside each map" } else { "takes no light" };
            return wrong(format!("the model {needed}; {} came", lights.map_or(0, <[MapLight<'_>]>::len)));
        }
        Ok(())
    }

    /// Runs one micro-batch of maps of one size.
    fn run(&mut self, size: usize, chosen: &[usize], maps: &[&SparseMap], lights: &[MapLight<'_>]) -> Result<()> {
        let Size { bins, batch, shape } = &self.sizes[size];
        let each = self.contract.input.values(*bins);
        self.values.clear();
        self.values.resize(batch * each, 0.0);
        for (&i, values) in chosen.iter().zip(self.values.chunks_exact_mut(each)) {
            self.contract.input.write(maps[i], values);
        }
        self.lights.clear();
        if self.contract.light.wanted() {
            let empty = iter::repeat_n(&OVERHEAD, batch - chosen.len());
            for light in chosen.iter().map(|&i| &lights[i].whole).chain(empty) {
                self.contract.light.write(light, &mut self.lights);
            }
        }
        self.mu.resize(batch * Material::LEN, 0.0);
        let batch = Batch { shape, maps: &self.values, lights: &self.lights };
        self.engine.run(batch, &mut self.mu).map_err(|found| Error::malformed(&self.contract.model, found))
    }
}

fn material(mu: &[f32]) -> Result<Material, String> {
    let mut v = [0.0; Material::LEN];
    for ((v, &mu), name) in v.iter_mut().zip(mu).zip(Material::NAMES) {
        if !(-SLACK..=1.0 + SLACK).contains(&mu) {
            return Err(format!("this batch has {name} = {mu}; the contract wants [0, 1]"));
        }
        *v = mu.clamp(0.0, 1.0);
    }
    Ok(Material::from(v))
}
