//! The fit: materials from maps by least squares, where the light is known.
//!
//! Once the roughness is fixed, radiance is linear in kd and ks. With A the radiance of a white Lambertian in the triangle's
//! light and B_j that of the specular lobe with ks = 1 towards bin j, channel by channel,
//!
//! ```text
//! L_j = kd A + ks B_j(r) + noise,   A = sun cos_i + sky,   B_j = sun pi f_r(wi, wo_j) cos_i + sky S(r, wo_j)
//! ```
//!
//! so that for each of [`LEVELS`] roughnesses the best kd and ks solve two linear equations (variable projection: Golub and
//! Pereyra, SIAM J. Numer. Anal. 10(2), 1973), kept in [0, 1]. Both have a Gaussian prior as wide as [0, 1], rather dark and
//! rather matt, which decides where the map says nothing. How well each roughness explains the map, its evidence (MacKay, Neural Computation 4(3),
//! 1992), weighs it, and the answer is the weighted mean: a map that shows a highlight has one roughness, and one that shows
//! none gets the middle of those that are possible. Their spread, and that of kd and ks at each, is the standard deviation
//! of the answer. A second pass gives less weight to bins that the first cannot explain,
//! which something that passed by may have filled, and none to clipped bins that are brighter than what they say.

mod session;
mod tables;
#[cfg(test)]
mod tests;

use std::path::PathBuf;

use super::contract::{Contract, Input};
use super::{Estimator, Session};
use crate::base::Result;
use crate::base::key::{Key, KeyBuilder};
use crate::base::units::Bytes;
use crate::scene::reflectance::{FRONT_BINS, Kind};
use session::FitSession;
use tables::LEVELS;

/// The fit as an estimator.
#[derive(Debug)]
pub struct Fit {
    contract: Contract,
}

/// Changes whenever the same map and light give another material.
const VERSION: &str = "1";

impl Default for Fit {
    fn default() -> Self {
        let contract = Contract {
            model: PathBuf::from("fit"),
            kind: Kind::Lobe,
            input: Input::Bins { most: FRONT_BINS },
            light: true,
            version: VERSION.into(),
            training: serde_json::Value::Null,
        };
        Fit { contract }
    }
}

impl Estimator for Fit {
    fn contract(&self) -> &Contract {
        &self.contract
    }

    fn describe(&self) -> String {
        format!("fit version {VERSION} (least squares in the known light, {LEVELS} roughnesses)")
    }

    fn key(&self) -> Key {
        KeyBuilder::new("gonio fit").field(VERSION.as_bytes()).finish()
    }

    fn engine(&self) -> String {
        "built in".to_owned()
    }

    fn micro_batch(&self) -> usize {
        1
    }

    fn memory(&self, sessions: usize) -> Bytes {
        Bytes(Bytes::MIB + sessions as u64 * FitSession::BYTES)
    }

    fn session(&self) -> Result<Box<dyn Session>> {
        Ok(Box::new(FitSession::default()))
    }
}
