//! One worker's fits.

use std::f32::consts::PI;

use glam::Vec3;

use super::tables::{DIRECTIONS, LEVELS, TABLES};
use crate::base::{Error, Result};
use crate::model::{Estimate, Session};
use crate::scene::Material;
use crate::scene::brdf::{distribution, fresnel, lambda};
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{COLUMNS, FRONT_BINS, SparseMap};

/// Means of the priors: outdoors most surfaces are darker than the middle of the range, and more of them matt than shiny.
const KD: f64 = 0.25;
const KS: f64 = 0.35;

/// Precision (one over the variance) of both: that of values spread evenly over [0, 1].
const PRECISION: f64 = 12.0;

/// Standard deviation of a bin's radiance: a part of its own, and a share of the radiance. Pixels are steps of 1/255, which
/// are fine where it is dark, and have neighbours mixed in; and a bin stands for all directions in it. Of the values tried on
/// a synthetic city, 0.002 to 0.03 and 0.02 to 0.15, these gave the smallest errors, by little.
const NOISE: f32 = 0.002;
const NOISE_SHARE: f32 = 0.05;

/// Residual, in standard deviations, at which a bin counts for half.
const FAR: f32 = 1.0;

/// Variance of a roughness within its step.
const STEP: f64 = 1.0 / (12 * LEVELS * LEVELS) as f64;

/// What deviations are multiplied by, component by component, so that two thirds of the truths lie within one: what the
/// model leaves out (pixels that are mixed, light from surface to surface, shadows' edges) is not in the noise. Measured on
/// a synthetic city of 51,000 triangles.
const CALIBRATION: [f64; Material::LEN] = [1.77, 1.77, 1.77, 0.8, 0.8, 0.8, 1.0];

/// No deviation is larger than that of values spread evenly over [0, 1].
const WIDEST: f64 = 0.288_7;

/// What is known of one bin.
#[derive(Debug, Clone, Copy)]
struct Seen {
    rgb: [f32; 3],
    /// One over the variance of the noise, channel by channel.
    precision: [f32; 3],
    /// What it counts for, 0 to 1.
    weight: f32,
    /// Whether most of its pixels were clipped, so that it says only how bright it is at least.
    clipped: bool,
    /// Of the direction: the row, and what the lobe takes of it.
    row: usize,
    facet: Facet,
}

/// What the lobe's terms need of a pair of directions.
#[derive(Debug, Clone, Copy)]
struct Facet {
    cos2: f32,
    sin2: f32,
    /// pi F / (4 cos_o); 0 where the sun is behind the surface.
    scale: f32,
}

/// What is kept from map to map.
#[derive(Default)]
pub struct FitSession {
    seen: Vec<Seen>,
    /// Radiance of the lobe with ks = 1 in the sun alone: level by level, the bins.
    lobe: Vec<f32>,
}

/// kd and ks of one roughness, their variances, and the logarithm of its evidence.
#[derive(Debug, Clone, Copy, Default)]
struct Solution {
    kd: [f64; 3],
    ks: [f64; 3],
    variance: [f64; 6],
    evidence: f64,
}

impl FitSession {
    /// Bytes that one holds at most.
    pub const BYTES: u64 = (FRONT_BINS * (size_of::<Seen>() + LEVELS * size_of::<f32>())) as u64;

    fn fit(&mut self, map: &SparseMap, light: &LocalLight) -> Estimate {
        self.look(map, light);
        let first = self.solve_all(light);
        self.weigh(&first, light);
        mean(&self.solve_all(light))
    }

    /// Gathers what does not change while the map is fitted.
    fn look(&mut self, map: &SparseMap, light: &LocalLight) {
        self.seen.clear();
        for (bin, sum) in map.bins.iter().filter(|(bin, _)| usize::from(*bin) < FRONT_BINS) {
            let rgb = sum.mean();
            let precision = rgb.map(|v| (NOISE * NOISE + (NOISE_SHARE * v).powi(2)).recip());
            let clipped = 2 * sum.clipped > sum.count;
            let facet = facet(light.direction, DIRECTIONS[usize::from(*bin)]);
            self.seen.push(Seen { rgb, precision, weight: 1.0, clipped, row: usize::from(*bin) / COLUMNS, facet });
        }
        self.lobe.clear();
        for level in TABLES.iter() {
            let sunward = lambda(level.alpha, light.direction.z.max(1e-4));
            self.lobe.extend(self.seen.iter().map(|bin| {
                let d = distribution(level.alpha, bin.facet.cos2, bin.facet.sin2);
                d * bin.facet.scale / (1.0 + sunward + level.lambda[bin.row])
            }));
        }
    }

    fn solve_all(&self, light: &LocalLight) -> [Solution; LEVELS] {
        std::array::from_fn(|level| self.solve(level, light))
    }

    fn solve(&self, level: usize, light: &LocalLight) -> Solution {
        let (lobe, sky) = (self.lobe(level), &TABLES[level].sky);
        let white = white(light);
        let mut solution = Solution::default();
        for c in 0..3 {
            let [mut w, mut wb, mut wbb, mut wl, mut wbl, mut wll] = [0f64; 6];
            for (bin, &lobe) in self.seen.iter().zip(lobe) {
                let weight = f64::from(bin.weight * bin.precision[c]);
                let b = f64::from(light.sun[c] * lobe + light.sky[c] * sky[bin.row]);
                let l = f64::from(bin.rgb[c]);
                w += weight;
                wb += weight * b;
                wbb += weight * b * b;
                wl += weight * l;
                wbl += weight * b * l;
                wll += weight * l * l;
            }
            let a = f64::from(white[c]);
            let right = [a * wl + PRECISION * KD, wbl + PRECISION * KS];
            let normal = [a * a * w + PRECISION, a * wb, wbb + PRECISION];
            let [kd, ks] = solve_within(normal, right);
            let [n, m, k] = normal;
            let misfit = wll + PRECISION * (KD * KD + KS * KS) - 2.0 * (kd * right[0] + ks * right[1])
                + n * kd * kd
                + 2.0 * m * kd * ks
                + k * ks * ks;
            let det = n * k - m * m;
            (solution.kd[c], solution.ks[c]) = (kd, ks);
            (solution.variance[c], solution.variance[3 + c]) = (k / det, n / det);
            solution.evidence -= 0.5 * (misfit + det.ln());
        }
        solution
    }

    /// Gives less weight to bins that the likeliest solution does not explain.
    fn weigh(&mut self, solutions: &[Solution; LEVELS], light: &LocalLight) {
        let best = (0..LEVELS).max_by(|&a, &b| solutions[a].evidence.total_cmp(&solutions[b].evidence)).unwrap_or(0);
        let (Solution { kd, ks, .. }, white) = (solutions[best], white(light));
        let sky = &TABLES[best].sky;
        let lobe = &self.lobe[best * self.seen.len()..][..self.seen.len()];
        for (bin, &lobe) in self.seen.iter_mut().zip(lobe) {
            let (mut far, mut brighter) = (0.0, true);
            for c in 0..3 {
                let shiny = light.sun[c] * lobe + light.sky[c] * sky[bin.row];
                let told = kd[c] as f32 * white[c] + ks[c] as f32 * shiny;
                far += (told - bin.rgb[c]).powi(2) * bin.precision[c] / 3.0;
                brighter &= told >= bin.rgb[c];
            }
            bin.weight = if bin.clipped && brighter { 0.0 } else { 1.0 / (1.0 + far / (FAR * FAR)) };
        }
    }

    fn lobe(&self, level: usize) -> &[f32] {
        &self.lobe[level * self.seen.len()..][..self.seen.len()]
    }
}

/// Radiance of a white Lambertian.
fn white(light: &LocalLight) -> Vec3 {
    light.sun * light.direction.z.max(0.0) + light.sky
}

fn facet(wi: Vec3, wo: Vec3) -> Facet {
    let h = (wi + wo).normalize_or_zero();
    let scale = if wi.z > 0.0 { PI * fresnel(wi.dot(h).clamp(0.0, 1.0)) / (4.0 * wo.z) } else { 0.0 };
    Facet { cos2: h.z * h.z, sin2: h.x * h.x + h.y * h.y, scale }
}

/// The minimum in [0, 1]^2 of the quadratic with this normal matrix (symmetric: upper left, off the diagonal, lower right)
/// and right side.
fn solve_within([n, m, k]: [f64; 3], [p, q]: [f64; 2]) -> [f64; 2] {
    let det = n * k - m * m;
    let free = [(p * k - q * m) / det, (q * n - p * m) / det];
    if free.iter().all(|v| (0.0..=1.0).contains(v)) {
        return free;
    }
    // It lies on one of the edges.
    let cost = |[x, y]: [f64; 2]| n * x * x + 2.0 * m * x * y + k * y * y - 2.0 * (p * x + q * y);
    let upright = [0.0, 1.0].map(|x| [x, ((q - m * x) / k).clamp(0.0, 1.0)]);
    let level = [0.0, 1.0].map(|y| [((p - m * y) / n).clamp(0.0, 1.0), y]);
    let edges = upright.into_iter().chain(level);
    edges.min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or([0.0; 2])
}

/// Mean and deviation of all roughnesses, weighted by their evidence.
fn mean(solutions: &[Solution; LEVELS]) -> Estimate {
    let most = solutions.iter().map(|s| s.evidence).fold(f64::NEG_INFINITY, f64::max);
    let (mut sum, mut squares, mut all) = ([0f64; Material::LEN], [0f64; Material::LEN], 0.0);
    for (s, level) in solutions.iter().zip(TABLES.iter()) {
        let weight = (s.evidence - most).exp();
        let values = s.kd.iter().chain(&s.ks).copied().chain([f64::from(level.r)]);
        for (c, (value, variance)) in values.zip(s.variance.into_iter().chain([STEP])).enumerate() {
            sum[c] += weight * value;
            squares[c] += weight * (value * value + variance);
        }
        all += weight;
    }
    let deviation = std::array::from_fn(|c| {
        let mean = sum[c] / all;
        (CALIBRATION[c] * (squares[c] / all - mean * mean).max(0.0).sqrt()).min(WIDEST) as f32
    });
    Estimate { material: Material::from(sum.map(|v| ((v / all) as f32).clamp(0.0, 1.0))), deviation }
}

impl Session for FitSession {
    fn estimate(&mut self, maps: &[&SparseMap], lights: Option<&[LocalLight]>, out: &mut [Estimate]) -> Result<()> {
        let lights = lights.filter(|lights| lights.len() == maps.len() && maps.len() == out.len());
        let lights = lights.ok_or_else(|| {
            Error::invalid(format!("fit: {} maps need as many lights and {} places", maps.len(), out.len()))
        })?;
        for ((map, light), out) in maps.iter().zip(lights).zip(out) {
            *out = self.fit(map, light);
        }
        Ok(())
    }
}
