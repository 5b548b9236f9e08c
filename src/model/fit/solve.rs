//! From sums over bins to materials: the best kd and ks of a roughness, how well it explains the map, and what all say together.

use glam::Vec3;

use super::sums::{Channel, Weights};
use super::tables::{LEVELS, Levels, TABLES};
use crate::model::Estimate;
use crate::scene::Material;

/// Variance of a roughness within its step.
const STEP: f64 = 1.0 / (12 * LEVELS * LEVELS) as f64;

/// What deviations are multiplied by, component by component, so that 68% of the truths lie within one: what the model
/// leaves out (pixels that are mixed, shadows' edges) is not in the noise. Measured on the synthetic city of seed 35.
const CALIBRATION: [f64; Material::LEN] = [1.30, 1.30, 1.30, 0.53, 0.53, 0.53, 0.62];

/// No deviation is larger than that of values spread evenly over [0, 1].
pub const WIDEST: f64 = 0.288_7;

/// Weight of a roughness, next to the likeliest's, that is none.
const NOTHING: f64 = 1e-12;

/// ks and roughness of a matt surface: the answer where a map tells neither. These and the two below were found on the
/// synthetic cities of seeds 35 to 37.
const MATT: [f64; 2] = [0.1, 0.75];

/// The share of the roughness's variance that a map leaves counts to the power of its bins over this: of two bins little
/// can be learned and a matt surface is likely, though a smooth one would explain them a bit better.
const PATIENCE: f64 = 3.0;

/// Bins at which ks moves half as far towards matt as the roughness does, which brings most of the good.
const SEVERAL: f64 = 8.0;

/// What is thought of a material before its map is looked at: Gaussians.
#[derive(Debug, Clone, Copy)]
pub struct Prior {
    /// Means of kd and ks.
    mean: [f64; 6],
    /// One over their variances.
    precision: [f64; 6],
    /// Logarithm of how likely each roughness is, but for a constant.
    roughness: Levels<f64>,
}

impl Prior {
    /// A component that nothing is said of has that of values spread evenly over [0, 1].
    pub fn of(guess: &Estimate) -> Prior {
        let variance = guess.deviation.map(|d| if d > 0.0 { f64::from(d).powi(2) } else { WIDEST * WIDEST });
        let mean = guess.material.to_array().map(f64::from);
        Prior {
            mean: std::array::from_fn(|c| mean[c]),
            precision: std::array::from_fn(|c| variance[c].recip()),
            roughness: TABLES.r.map(|r| -0.5 * (f64::from(r) - mean[6]).powi(2) / variance[6]),
        }
    }
}

/// kd and ks of one roughness, their variances, and the logarithm of its evidence.
#[derive(Debug, Clone, Copy, Default)]
pub struct Solution {
    /// Diffuse.
    pub kd: [f64; 3],
    /// Specular.
    pub ks: [f64; 3],
    variance: [f64; 6],
    /// Its logarithm, but for a constant.
    pub evidence: f64,
}

/// kd and ks of one roughness, channel by channel, in the light that a white Lambertian has radiance `white` in.
pub fn solve(level: usize, weights: &Weights, channels: &[Channel; 3], prior: &Prior, white: Vec3) -> Solution {
    let mut solution =
        Solution { evidence: prior.roughness[level] - 1.5 * weights.spread[level], ..Solution::default() };
    let (w, mut dets) = (weights.sum[level], 1.0);
    for (c, sums) in channels.iter().enumerate() {
        let (a, wb, wbb, wbl) = (f64::from(white[c]), sums.wb[level], sums.wbb[level], sums.wbl[level]);
        let (before, sure) = ([prior.mean[c], prior.mean[3 + c]], [prior.precision[c], prior.precision[3 + c]]);
        let right = [a * sums.wl[level] + sure[0] * before[0], wbl + sure[1] * before[1]];
        let normal = [a * a * w + sure[0], a * wb, wbb + sure[1]];
        let [kd, ks] = solve_within(normal, right);
        let [n, m, k] = normal;
        let misfit = sums.wll[level] + sure[0] * before[0].powi(2) + sure[1] * before[1].powi(2)
            - 2.0 * (kd * right[0] + ks * right[1])
            + n * kd * kd
            + 2.0 * m * kd * ks
            + k * ks * ks;
        let det = n * k - m * m;
        (solution.kd[c], solution.ks[c]) = (kd, ks);
        (solution.variance[c], solution.variance[3 + c]) = (k / det, n / det);
        solution.evidence -= 0.5 * misfit;
        dets *= det;
    }
    solution.evidence -= 0.5 * dets.ln();
    solution
}

/// What all roughnesses say, weighted by their evidence, of a map of so many bins.
pub fn together(solutions: &[Solution; LEVELS], bins: usize) -> Estimate {
    let most = solutions.iter().map(|s| s.evidence).fold(f64::NEG_INFINITY, f64::max);
    // What weighs next to nothing is left out: numbers that small are slow, and change nothing.
    let weights = solutions.map(|s| Some((s.evidence - most).exp()).filter(|weight| *weight >= NOTHING).unwrap_or(0.0));
    let all: f64 = weights.iter().sum();
    let (mut answer, mut squares, mut below, mut median) = ([0f64; Material::LEN], [0f64; Material::LEN], 0.0, 0.0);
    for ((s, r), weight) in solutions.iter().zip(TABLES.r).zip(weights).filter(|(_, weight)| *weight > 0.0) {
        let (weight, r) = (weight / all, f64::from(r));
        let ([kr, kg, kb], [sr, sg, sb]) = (s.kd, s.ks);
        let values = [kr, kg, kb, sr, sg, sb, r];
        for c in 0..Material::LEN {
            let variance = s.variance.get(c).copied().unwrap_or(STEP);
            answer[c] += weight * values[c];
            squares[c] += weight * (values[c] * values[c] + variance);
        }
        if below < 0.5 {
            median = r + ((0.5 - below) / weight).min(1.0) / LEVELS as f64 - 0.5 / LEVELS as f64;
        }
        below += weight;
    }
    let mut variance: [f64; Material::LEN] = std::array::from_fn(|c| (squares[c] - answer[c] * answer[c]).max(0.0));
    // How near to matt: all the way where the roughness is as unsure as before the map was looked at.
    let bins = bins as f64;
    let unsure = (variance[6] / (WIDEST * WIDEST)).min(1.0).powf(bins / PATIENCE);
    let little = unsure / (1.0 + (bins / SEVERAL).powi(2));
    let mean = answer;
    (3..6).for_each(|c| answer[c] += little * (MATT[0] - answer[c]).min(0.0));
    answer[6] = median + unsure * (MATT[1] - median).max(0.0);
    (0..Material::LEN).for_each(|c| variance[c] += (answer[c] - mean[c]).powi(2));
    let deviation = std::array::from_fn(|c| (CALIBRATION[c] * variance[c].sqrt()).min(WIDEST) as f32);
    Estimate { material: Material::from(answer.map(|v| (v as f32).clamp(0.0, 1.0))), deviation }
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
