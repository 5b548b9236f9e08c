//! Training maps as scenes give them: `lobe` maps of random materials of which flights fill few bins.
//!
//! A sample draws a surface among ground, roofs and walls, the surface's material and light from a [`Prior`], and a flight
//! (`flight`): orbits, blocks, or both. Each frame that sees the surface gives a few pixels: radiance of the BRDF under sun
//! and constant sky, or under the sky alone in shadow, clipped at 1, in 8-bit sRGB steps. In half of the samples exposure
//! wavers from frame to frame. A tenth of the samples has a frame that shows something else, and a tenth is filled densely
//! at random. Maps with fewer than three bins are drawn again.
//!
//! A sample is [`SAMPLE`] bytes, little endian: `u32` filled bins n; `u16` bins [64]; `f32` mean radiance [64][3];
//! `f32` material [7]; `f32` unit vector to the sun [3]; `f32` colour of the sun [3], 0 where the sun does not reach the
//! surface; `f32` radiance of the sky that reaches the surface [3]. Slots past n are zero. Maps with more than 64 filled
//! bins keep a random 64. A sample depends on prior, seed and index alone.

mod flight;
mod prior;
#[cfg(test)]
mod tests;

pub(crate) use prior::Prior;

use std::io::{self, Write};

use glam::Vec3;
use prior::Lit;
use rand::seq::SliceRandom;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;
use rayon::prelude::*;

use crate::base::convert::{Cut, to_u32, to_usize};
use crate::scene::Material;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{self, Bin, FRONT_BINS, LobeFrame, bin_of, direction_of};

/// The most bins of a sample.
pub(crate) const SLOTS: usize = 64;
/// Bytes of a sample.
#[cfg(test)]
pub(crate) const SAMPLE: usize = 4 + SLOTS * (2 + 12) + 4 * (Material::LEN + 9);
/// The fewest bins of a sample.
const FEWEST: usize = 3;
/// Samples made and written at a time.
const BATCH: u64 = 8192;

/// Writes samples `0..count` of a prior and a seed.
pub(crate) fn write(out: &mut (impl Write + ?Sized), prior: Prior, seed: u64, count: u64) -> io::Result<()> {
    let table = srgb_steps();
    for start in (0..count).step_by(to_usize(BATCH)) {
        let end = count.min(start + BATCH);
        let bytes: Vec<u8> = (start..end)
            .into_par_iter()
            .fold(Vec::new, |mut bytes, index| {
                Sample::draw(prior, seed, index, &table).append_to(&mut bytes);
                bytes
            })
            .collect::<Vec<_>>()
            .concat();
        out.write_all(&bytes)?;
    }
    out.flush()
}

/// One training sample.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Sample {
    /// Filled bins with their mean radiance, ascending, at most [`SLOTS`].
    pub bins: Vec<(Bin, [f32; 3])>,
    /// The material of the surface.
    pub material: Material,
    /// The light that reached the surface.
    pub light: LocalLight,
}

impl Sample {
    /// The sample at an index of a seed. `steps` is [`srgb_steps`].
    pub(crate) fn draw(prior: Prior, seed: u64, index: u64, steps: &[f32]) -> Sample {
        let mut rng = Pcg64Mcg::seed_from_u64(seed.wrapping_mul(0x9e37_79b9_7f4a_7c15).wrapping_add(index));
        loop {
            let frame = LobeFrame::new(flight::surface(&mut rng));
            let lit = Lit::draw(prior, &frame, &mut rng);
            let mut bins =
                if rng.random_bool(0.1) { dense(&mut rng, &lit, steps) } else { seen(&mut rng, &frame, &lit, steps) };
            if bins.len() < FEWEST {
                continue;
            }
            if bins.len() > SLOTS {
                bins.shuffle(&mut rng);
                bins.truncate(SLOTS);
                bins.sort_unstable_by_key(|b| b.0);
            }
            return Sample { bins, material: lit.material, light: lit.light };
        }
    }

    /// Appends the sample's bytes.
    pub(crate) fn append_to(&self, out: &mut Vec<u8>) {
        out.extend(to_u32(self.bins.len()).to_le_bytes());
        let slots = |i: usize| self.bins.get(i).copied().unwrap_or_default();
        (0..SLOTS).for_each(|i| out.extend(slots(i).0.to_le_bytes()));
        (0..SLOTS).flat_map(|i| slots(i).1).for_each(|v| out.extend(v.to_le_bytes()));
        let LocalLight { direction, sun, sky } = self.light;
        let light = [direction, sun, sky].into_iter().flat_map(|v| v.to_array());
        self.material.to_array().into_iter().chain(light).for_each(|v| out.extend(v.to_le_bytes()));
    }
}

/// For each 16-bit step of linear radiance, the radiance after a camera has stored the step in 8-bit sRGB.
pub(crate) fn srgb_steps() -> Vec<f32> {
    (0..=u16::MAX)
        .map(|i| {
            let linear = f32::from(i) / 65_535.0;
            let stored = if linear <= 0.003_130_8 { 12.92 * linear } else { 1.055 * linear.powf(1.0 / 2.4) - 0.055 };
            let stored = (stored * 255.0).round() / 255.0;
            if stored <= 0.040_45 { stored / 12.92 } else { ((stored + 0.055) / 1.055).powf(2.4) }
        })
        .collect()
}

/// Radiance as a camera stores it.
fn stored(radiance: Vec3, steps: &[f32]) -> [f32; 3] {
    radiance.to_array().map(|v| steps[usize::cut(v.clamp(0.0, 1.0) * 65_535.0 + 0.5)])
}

/// Front bins at random, more than any flight fills.
fn dense(rng: &mut impl Rng, lit: &Lit, steps: &[f32]) -> Vec<(Bin, [f32; 3])> {
    let front = Bin::try_from(FRONT_BINS).unwrap_or(Bin::MAX);
    let mut bins: Vec<Bin> = (0..2 * SLOTS).map(|_| rng.random_range(0..front)).collect();
    bins.sort_unstable();
    bins.dedup();
    bins.into_iter().map(|b| (b, stored(lit.radiance(direction_of(b)), steps))).collect()
}

/// The bins that a flight fills.
fn seen(rng: &mut impl Rng, frame: &LobeFrame, lit: &Lit, steps: &[f32]) -> Vec<(Bin, [f32; 3])> {
    let views = flight::views(rng);
    let wavering = if rng.random_bool(0.5) { rng.random_range(0.0..0.02f32) } else { 0.0 };
    // A triangle is seen under slightly different directions across its face.
    let spread = rng.random_range(0.001..0.015f32);
    let pixels = rng.random_range(1..=4);
    let outlier = rng.random_bool(0.1).then(|| rng.random_range(0..views.len().max(1)));
    let mut sums: Vec<(Bin, Vec3, f32)> = Vec::with_capacity(views.len());
    for (i, view) in views.into_iter().enumerate() {
        let exposure = 1.0 + wavering * flight::bell(rng);
        let other = Vec3::new(rng.random(), rng.random(), rng.random());
        for _ in 0..pixels {
            let jitter = Vec3::new(flight::bell(rng), flight::bell(rng), flight::bell(rng)) * spread;
            let wo = frame.to_local((view + jitter).normalize());
            // Flatter than 4 degrees, a triangle covers no pixel.
            if wo.z < 0.07 {
                continue;
            }
            let radiance = if outlier == Some(i) { other } else { lit.radiance(wo) };
            let rgb = Vec3::from(stored(radiance * exposure, steps));
            let bin = bin_of(wo);
            match sums.iter_mut().rev().take(pixels).find(|s| s.0 == bin) {
                Some(sum) => (sum.1, sum.2) = (sum.1 + rgb, sum.2 + 1.0),
                None => sums.push((bin, rgb, 1.0)),
            }
        }
    }
    sums.sort_by_key(|s| s.0);
    sums.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            (kept.1, kept.2) = (kept.1 + next.1, kept.2 + next.2);
        }
        same
    });
    debug_assert!(sums.iter().all(|s| usize::from(s.0) < reflectance::FRONT_BINS));
    sums.into_iter().map(|(bin, rgb, n)| (bin, (rgb / n).to_array())).collect()
}
