//! One worker's fits.

use std::f32::consts::PI;

use glam::Vec3;

use super::solve::{Prior, Solution, solve, together};
use super::sums::{Channel, Weights};
use super::tables::{DIRECTIONS, LEVELS, Levels, TABLES};
use crate::model::estimator::Estimate;
use crate::scene::Material;
use crate::scene::brdf::{distribution, fresnel, lambda};
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{COLUMNS, FRONT_BINS, SparseMap};

/// The standard deviation of a bin's radiance, in steps of 8 bits: JPEG adds to what rounding makes.
const STEPS: f64 = 1.35;

/// The least standard deviation of a bin's radiance.
const DARK: f64 = 0.002;

/// The uncertainty of the lobe within a bin, as a share of the lobe: a bin stands for all its directions, and is compared with
/// the lobe at its middle.
const WITHIN_BIN: f64 = 0.1;

/// The mean ks that the first pass assumes for that uncertainty.
const SOME_KS: f64 = 0.5;

/// The largest squared residual of a bin that counts in full, relative to the mean one: noise alone reaches it.
const NEAR: f64 = 0.5;

/// The residual beyond [`NEAR`], in standard deviations, at which a bin counts for a quarter (Geman and McClure's weights).
const FAR: f64 = 1.5;

/// The number of pixels at which a bin's noise has twice the variance of a bin of many pixels. Of few pixels more lie on the
/// triangle's edge and show its neighbours. This was the best of 3 to 300 on a synthetic city.
const FEW: f64 = 30.0;

/// The number of unknowns of a map: three kd, three ks, one roughness.
const UNKNOWNS: usize = Material::LEN;

/// One bin of the map.
#[derive(Debug, Clone, Copy)]
struct Seen {
    rgb: [f32; 3],
    /// The bin's weight, 0 to 1.
    weight: f64,
    /// The bin's largest weight, by its number of pixels: 1 for the bin with the most.
    share: f64,
    /// The variance of the bin's noise.
    noise: f64,
    /// The sum of the squared residuals of the channels, in variances of the noise.
    far: f64,
    /// Whether most of the bin's pixels were clipped, so that its radiance is a lower bound.
    clipped: bool,
    /// The bin's row.
    row: usize,
    /// The light that the bin was seen in.
    sun: Vec3,
    sky: Vec3,
    /// The radiance of a white Lambertian in that light.
    white: Vec3,
}

/// The terms of a pair of directions in the lobe.
#[derive(Debug, Clone, Copy)]
struct Facet {
    cos2: f32,
    sin2: f32,
    /// pi F / (4 cos_o); 0 where the sun is behind the surface.
    scale: f32,
}

/// The buffers of a worker's fits.
#[derive(Default)]
pub(super) struct FitSession {
    seen: Vec<Seen>,
    /// The radiance of the lobe with ks = 1 in the sun alone, bin by bin.
    lobe: Vec<Levels>,
    weights: Weights,
}

impl FitSession {
    /// The most bytes that a session holds: a bin may be seen in the sun and in the shade.
    pub(super) const BYTES: u64 =
        2 * (FRONT_BINS * (size_of::<Seen>() + size_of::<Levels>() + size_of::<Levels<f64>>())) as u64;

    /// Fits the material of a map whose parts were seen in these lights. `guess` is the prior, with its deviations.
    pub(super) fn fit(&mut self, parts: &[(&SparseMap, LocalLight)], guess: &Estimate) -> Estimate {
        let prior = Prior::of(guess);
        self.look(parts);
        let first = self.solve_all(&prior, 1.0, &[SOME_KS; LEVELS]);
        let larger = self.weigh(&first);
        let shine = std::array::from_fn(|level| first[level].ks.iter().sum::<f64>() / 3.0);
        together(&self.solve_all(&prior, larger, &shine), self.seen.len())
    }

    /// Computes the terms that stay the same while the map is fitted.
    fn look(&mut self, parts: &[(&SparseMap, LocalLight)]) {
        self.seen.clear();
        self.lobe.clear();
        let share = |count: u32| f64::from(count) / (f64::from(count) + FEW);
        let bins = parts.iter().flat_map(|(map, _)| &map.bins);
        let most = bins.map(|(_, sum)| share(sum.count)).fold(0.0, f64::max);
        for (map, light) in parts {
            let LocalLight { direction, sun, sky } = *light;
            let white = sun * direction.z.max(0.0) + sky;
            let sunward = TABLES.alpha.map(|alpha| lambda(alpha, direction.z.max(1e-4)));
            for (bin, sum) in map.bins.iter().filter(|(bin, _)| usize::from(*bin) < FRONT_BINS) {
                let clipped = 2 * sum.clipped > sum.count;
                let (share, row) = (share(sum.count) / most, usize::from(*bin) / COLUMNS);
                let (rgb, far, weight) = (sum.mean(), 0.0, share);
                let noise = noise(rgb).powi(2);
                self.seen.push(Seen { rgb, weight, share, noise, far, clipped, row, sun, sky, white });
                let Facet { cos2, sin2, scale } = facet(direction, DIRECTIONS[usize::from(*bin)]);
                let away = &TABLES.lambda[row];
                self.lobe.push(std::array::from_fn(|level| {
                    distribution(TABLES.alpha[level], cos2, sin2) * scale / (1.0 + sunward[level] + away[level])
                }));
            }
        }
    }

    /// Solves for the best kd and ks of each roughness. The noise's variance is `larger` times that of the bins; `shine` is roughly
    /// each roughness's mean ks.
    fn solve_all(&mut self, prior: &Prior, larger: f64, shine: &Levels<f64>) -> [Solution; LEVELS] {
        let bins = self.seen.iter().zip(&self.lobe);
        self.weights.set(bins.clone().map(|(bin, lobe)| {
            let sheen = &TABLES.sky[bin.row];
            let noise = bin.noise * larger;
            let blurred = shine.map(|ks| WITHIN_BIN * ks / noise.sqrt());
            let (sun, sky) = (bin.sun.element_sum() / 3.0, bin.sky.element_sum() / 3.0);
            let blur = |i: usize| blurred[i] * f64::from(sun * lobe[i] + sky * sheen[i]);
            (bin.weight / noise, std::array::from_fn(blur))
        }));
        let bins = bins.zip(&self.weights.bins);
        let channels = [0, 1, 2].map(|c| {
            Channel::of(bins.clone().map(|((bin, lobe), weight)| {
                let sheen = &TABLES.sky[bin.row];
                (weight, [bin.rgb[c], bin.white[c]], move |i: usize| bin.sun[c] * lobe[i] + bin.sky[c] * sheen[i])
            }))
        });
        std::array::from_fn(|level| solve(level, &self.weights, &channels, prior))
    }

    /// Gives less weight to bins that the likeliest solution does not explain. Returns the factor by which the noise is larger than
    /// that of the bins: where pixels mix neighbours, all bins are off, and that must not look like a highlight.
    fn weigh(&mut self, solutions: &[Solution; LEVELS]) -> f64 {
        let best = (0..LEVELS).max_by(|&a, &b| solutions[a].evidence.total_cmp(&solutions[b].evidence)).unwrap_or(0);
        let Solution { kd, ks, .. } = solutions[best];
        let mean_ks = ks.iter().sum::<f64>() / 3.0;
        for (bin, lobe) in self.seen.iter_mut().zip(&self.lobe) {
            let shiny = bin.sun * lobe[best] + bin.sky * TABLES.sky[bin.row][best];
            let blur = WITHIN_BIN * mean_ks * f64::from(shiny.element_sum() / 3.0);
            let off = |c: usize| kd[c] * f64::from(bin.white[c]) + ks[c] * f64::from(shiny[c]) - f64::from(bin.rgb[c]);
            let off = [off(0), off(1), off(2)];
            let brighter = off.iter().all(|off| *off >= 0.0);
            bin.far = bin.share * off.iter().map(|off| off * off).sum::<f64>() / (bin.noise + blur * blur);
            // An answer brighter than a clipped bin is no misfit.
            bin.weight = if bin.clipped && brighter { 0.0 } else { bin.share };
        }
        let sum: f64 = self.seen.iter().filter(|bin| bin.weight > 0.0).map(|bin| bin.far).sum();
        let free = (3 * self.seen.len()).saturating_sub(UNKNOWNS).max(3);
        let larger = (sum / free as f64).max(1.0);
        for bin in &mut self.seen {
            let beyond = (bin.far / (3.0 * larger) - NEAR).max(0.0);
            bin.weight /= (1.0 + beyond / (FAR * FAR)).powi(2);
        }
        larger
    }
}

fn facet(wi: Vec3, wo: Vec3) -> Facet {
    let h = (wi + wo).normalize_or_zero();
    let scale = if wi.z > 0.0 { PI * fresnel(wi.dot(h).clamp(0.0, 1.0)) / (4.0 * wo.z) } else { 0.0 };
    Facet { cos2: h.z * h.z, sin2: h.x * h.x + h.y * h.y, scale }
}

/// The standard deviation of the noise at a radiance. A step of 8 bits is small where it is dark, which is what tells the colours
/// of what lies in the shade: the slope of sRGB's curve (IEC 61966-2-1) over 255, 2.4 / 1.055 L^(1.4 / 2.4).
fn noise(rgb: [f32; 3]) -> f64 {
    let mean = f64::from(rgb.iter().sum::<f32>() / 3.0);
    DARK.hypot(STEPS * 2.4 / 1.055 / 255.0 * mean.max(0.0).powf(1.4 / 2.4))
}
