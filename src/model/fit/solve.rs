//! From sums over bins to materials: the best kd and ks of a roughness, its evidence, and the answer of all roughnesses together.

use super::sums::{Channel, Weights};
use super::tables::{LEVELS, Levels, TABLES};
use crate::base::convert::to_f32;
use crate::model::estimator::Estimate;
use crate::scene::Material;

/// The variance of a roughness within its step.
const STEP: f64 = 1.0 / (12 * LEVELS * LEVELS) as f64;

/// The factors of the deviations, component by component, that bring 68% of the truths within one deviation: effects that the
/// model leaves out (mixed pixels, shadows' edges) are not in the noise. Measured on the synthetic city of seed 35.
const CALIBRATION: [f64; Material::LEN] = [1.30, 1.30, 1.30, 0.53, 0.53, 0.53, 0.62];

/// The largest deviation: that of values spread evenly over [0, 1].
pub(super) const WIDEST: f64 = 0.288_7;

/// The weight of a roughness, relative to the likeliest, below which it counts as 0.
const NOTHING: f64 = 1e-12;

/// ks and roughness of a matt surface, the answer if a map tells neither. These and the two constants below were found on the
/// synthetic cities of seeds 35 to 37.
const MATT: [f64; 2] = [0.1, 0.75];

/// The share of the roughness's variance that a map leaves is raised to the power of the map's bins over this number: two bins
/// tell little, and a matt surface is likely even if a smooth one explains them a bit better.
const PATIENCE: f64 = 3.0;

/// The number of bins at which ks moves half as far towards matt as the roughness does; the roughness brings most of the gain.
const SEVERAL: f64 = 8.0;

/// The prior of a material: Gaussians.
#[derive(Debug, Clone, Copy)]
pub(super) struct Prior {
    /// The means of kd and ks.
    mean: [f64; 6],
    /// One over the variances of kd and ks.
    precision: [f64; 6],
    /// The logarithm of each roughness's likelihood, up to a constant.
    roughness: Levels<f64>,
}

impl Prior {
    /// The prior that a guess stands for. A component without a deviation gets that of values spread evenly over [0, 1].
    pub(super) fn of(guess: &Estimate) -> Prior {
        let variance = guess.deviation.map(|d| if d > 0.0 { f64::from(d).powi(2) } else { WIDEST * WIDEST });
        let mean = guess.material.to_array().map(f64::from);
        Prior {
            mean: std::array::from_fn(|c| mean[c]),
            precision: std::array::from_fn(|c| variance[c].recip()),
            roughness: TABLES.r.map(|r| -0.5 * (f64::from(r) - mean[6]).powi(2) / variance[6]),
        }
    }
}

/// The kd and ks of one roughness, their variances, and the roughness's evidence.
#[derive(Debug, Clone, Copy, Default)]
pub(super) struct Solution {
    /// The diffuse scale, kd.
    pub kd: [f64; 3],
    /// The specular scale, ks.
    pub ks: [f64; 3],
    variance: [f64; 6],
    /// The logarithm of the roughness's evidence, up to a constant.
    pub evidence: f64,
}

/// Solves for kd and ks of one roughness, channel by channel.
pub(super) fn solve(level: usize, weights: &Weights, channels: &[Channel; 3], prior: &Prior) -> Solution {
    let mut solution =
        Solution { evidence: prior.roughness[level] - 1.5 * weights.spread[level], ..Solution::default() };
    let mut dets = 1.0;
    for (c, sums) in channels.iter().enumerate() {
        let (before, sure) = ([prior.mean[c], prior.mean[3 + c]], [prior.precision[c], prior.precision[3 + c]]);
        let right = [sums.wal[level] + sure[0] * before[0], sums.wbl[level] + sure[1] * before[1]];
        let normal = [sums.waa[level] + sure[0], sums.wab[level], sums.wbb[level] + sure[1]];
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

/// The answer of all roughnesses, weighted by their evidence, for a map with this many bins.
pub(super) fn together(solutions: &[Solution; LEVELS], bins: usize) -> Estimate {
    let most = solutions.iter().map(|s| s.evidence).fold(f64::NEG_INFINITY, f64::max);
    // Tiny weights are left out: denormal numbers are slow and change nothing.
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
    // The move towards matt: all the way if the roughness is as uncertain as in the prior.
    let bins = bins as f64;
    let unsure = (variance[6] / (WIDEST * WIDEST)).min(1.0).powf(bins / PATIENCE);
    let little = unsure / (1.0 + (bins / SEVERAL).powi(2));
    let mean = answer;
    (3..6).for_each(|c| answer[c] += little * (MATT[0] - answer[c]).min(0.0));
    answer[6] = median + unsure * (MATT[1] - median).max(0.0);
    (0..Material::LEN).for_each(|c| variance[c] += (answer[c] - mean[c]).powi(2));
    let deviation = std::array::from_fn(|c| to_f32((CALIBRATION[c] * variance[c].sqrt()).min(WIDEST)));
    Estimate { material: Material::from(answer.map(|v| to_f32(v).clamp(0.0, 1.0))), deviation }
}

/// The minimum in [0, 1]^2 of the quadratic with this normal matrix (symmetric: upper left, off the diagonal, lower right)
/// and right side.
fn solve_within([n, m, k]: [f64; 3], [p, q]: [f64; 2]) -> [f64; 2] {
    let det = n * k - m * m;
    let free = [(p * k - q * m) / det, (q * n - p * m) / det];
    if free.iter().all(|v| (0.0..=1.0).contains(v)) {
        return free;
    }
    // The minimum lies on one of the edges.
    let cost = |[x, y]: [f64; 2]| n * x * x + 2.0 * m * x * y + k * y * y - 2.0 * (p * x + q * y);
    let upright = [0.0, 1.0].map(|x| [x, ((q - m * x) / k).clamp(0.0, 1.0)]);
    let level = [0.0, 1.0].map(|y| [((p - m * y) / n).clamp(0.0, 1.0), y]);
    let edges = upright.into_iter().chain(level);
    edges.min_by(|a, b| cost(*a).total_cmp(&cost(*b))).unwrap_or([0.0; 2])
}
