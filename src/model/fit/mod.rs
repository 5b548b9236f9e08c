//! The fit: materials from maps by least squares, where the light is known.
//!
//! Once the roughness is fixed, radiance is linear in kd and ks. With A the radiance of a white Lambertian in the triangle's
//! light and B_j that of the specular lobe with ks = 1 towards bin j, channel by channel,
//!
//! ```text
//! L_j = kd A + ks B_j(r) + noise,   A = sun cos_i + sky,   B_j = sun pi f_r(wi, wo_j) cos_i + sky S(r, wo_j)
//! ```
//!
//! so for each of [`LEVELS`] roughnesses the best kd and ks solve two linear equations (variable projection: Golub and Pereyra,
//! SIAM J. Numer. Anal. 10(2), 1973), kept in [0, 1]. kd and ks have Gaussian priors at least as wide as [0, 1], rather dark and
//! rather matt, which decide where the map has no information. The evidence of a roughness (MacKay, Neural Computation 4(3),
//! 1992) is its weight. The answer is the weighted mean of kd and ks and the weighted median of the roughness, with standard
//! deviations.
//!
//! A map without a highlight belongs to a matt surface, or to a surface so smooth that no view came near its highlight. A
//! roughness halfway between them would show a highlight that neither has, as soon as the sun moves, and most when the sun is low.
//! The median is seldom halfway. The less a map tells about the roughness, and the fewer bins it has, the nearer the answer
//! moves to matt, smoothly, so that it relights no worse than a Lambertian would.
//!
//! A bin's radiance is uncertain by a step of 8 bits in the photograph, and by a share of the lobe's radiance, since the lobe
//! changes within the bin; a bin of few pixels is less certain. A second pass sets the noise to the residuals of the first. It gives less weight to
//! bins that it cannot explain, since a passing object may have filled them, and none to clipped bins where it expects more light.

mod session;
mod solve;
mod sums;
mod tables;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use super::contract::{Contract, Input, LightInput};
use super::estimator::{Estimate, Estimator, MapLight, Session};
use crate::base::convert::to_f32;
use crate::base::key::{Key, KeyBuilder};
use crate::base::units::Bytes;
use crate::base::{Error, Result};
use crate::scene::Material;
use crate::scene::reflectance::{FRONT_BINS, Layout, SparseMap};
use session::FitSession;
use tables::LEVELS;

/// The fit as an estimator, alone or after a network. The network's answer and its deviations are then the prior of the
/// material, and the map in the known light moves the answer from there.
pub struct Fit {
    contract: Contract,
    network: Option<Box<dyn Estimator>>,
}

/// The fit's version. It changes whenever the same map and light give another material.
const VERSION: &str = "5";

/// The standard deviation of values spread evenly over [0, 1].
const WIDE: f32 = to_f32(solve::WIDEST);

/// The factors of the deviations after a network, whose answer is of the same map, which the fit takes for news. With them 68% of
/// the truths lie within one deviation on the synthetic cities of seeds 221 to 223.
const AFTER_NETWORK: [f32; Material::LEN] = [1.2, 1.2, 1.2, 1.23, 1.23, 1.23, 1.45];

/// The prior of a material without a network: outdoors most surfaces are darker than the middle of the range, and more of them
/// are matt than shiny. ks is the least certain.
const OUTDOORS: Estimate = Estimate {
    material: Material { kd: [0.25; 3], ks: [0.35; 3], r: 0.5 },
    // Every roughness is equally likely.
    deviation: [WIDE, WIDE, WIDE, 0.4, 0.4, 0.4, f32::INFINITY],
};

impl Fit {
    /// The fit, after a network or alone.
    pub fn new(network: Option<Box<dyn Estimator>>) -> Fit {
        let contract = Contract {
            model: PathBuf::from("fit"),
            kind: Layout::Lobe,
            input: Input::Bins { most: FRONT_BINS },
            light: LightInput::Whole,
            version: VERSION.into(),
            deviation: None,
            training: serde_json::Value::Null,
        };
        Fit { contract, network }
    }
}

impl Estimator for Fit {
    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn describe(&self) -> String {
        let network = self.network.as_ref().map_or(String::new(), |network| format!(", from {}", network.describe()));
        format!("fit version {VERSION} (least squares in the known light, {LEVELS} roughnesses){network}")
    }

    fn key(&self) -> Key {
        let key = KeyBuilder::new("gonio fit").field(VERSION.as_bytes());
        self.network.iter().fold(key, |key, network| key.key(network.key())).finish()
    }

    fn engine(&self) -> String {
        self.network.as_ref().map_or("built in".to_owned(), |network| network.engine())
    }

    fn micro_batch(&self) -> usize {
        self.network.as_ref().map_or(1, |network| network.micro_batch())
    }

    fn memory(&self, sessions: usize) -> Bytes {
        let network = self.network.as_ref().map_or(Bytes(0), |network| network.memory(sessions));
        Bytes(network.0 + Bytes::MIB + sessions as u64 * FitSession::BYTES)
    }

    fn session(&self) -> Result<Box<dyn Session>> {
        let session =
            |network: &dyn Estimator| -> Result<_> { Ok((network.contract().light.wanted(), network.session()?)) };
        let network = self.network.as_deref().map(session).transpose()?;
        Ok(Box::new(Worker { fit: FitSession::default(), network }))
    }
}

/// One worker's fits, and its session of the network. The flag says whether the network takes the light.
struct Worker {
    fit: FitSession,
    network: Option<(bool, Box<dyn Session>)>,
}

impl Session for Worker {
    fn estimate(&mut self, maps: &[&SparseMap], lights: Option<&[MapLight<'_>]>, out: &mut [Estimate]) -> Result<()> {
        let lights = lights.filter(|lights| lights.len() == maps.len() && maps.len() == out.len());
        let lights = lights.ok_or_else(|| {
            Error::invalid(format!("fit: {} maps need as many lights and {} places", maps.len(), out.len()))
        })?;
        match &mut self.network {
            Some((light, network)) => network.estimate(maps, light.then_some(lights), out)?,
            None => out.fill(OUTDOORS),
        }
        let wider = if self.network.is_some() { AFTER_NETWORK } else { [1.0; Material::LEN] };
        for ((map, light), out) in maps.iter().zip(lights).zip(out) {
            let whole = [(*map, light.whole)];
            *out = self.fit.fit(if light.parts.is_empty() { &whole } else { light.parts }, out);
            out.deviation.iter_mut().zip(wider).for_each(|(deviation, by)| *deviation = (*deviation * by).min(WIDE));
        }
        Ok(())
    }
}
