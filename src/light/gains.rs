//! Exposure: by which factor is each frame brighter than the others?
//!
//! The logarithm of a sighting's luminance is its frame's gain plus its triangle's brightness. Triangles are eliminated
//! (Schur's complement), and the frames' equations are solved by conjugate gradients without forming them, so memory grows
//! with the sightings alone. Sightings that do not fit, such as highlights and what moved, lose weight round by round
//! (Geman and McClure).

use super::observed::Sighting;
use super::rows::{Row, rows};
use super::tied::tied;
use super::weights::weigh;
use crate::base::convert::to_f32;

/// The gains of frames.
#[derive(Debug, Clone, PartialEq)]
pub struct Gains {
    /// Logarithm of the factor that each frame's linear radiance is divided by; `None` for a frame that shares too few
    /// triangles with the others.
    pub log: Vec<Option<f32>>,
    /// Standard deviation of what the gains leave of a sighting, in logarithms, without outliers.
    pub residual: f32,
}

impl Gains {
    /// Gains of 1 for all frames.
    pub fn none(frames: usize) -> Gains {
        Gains { log: vec![Some(0.0); frames], residual: 0.0 }
    }

    /// The factor that a frame's linear radiance is divided by; `None` for a frame that could not be tied to the others.
    pub fn factor(&self, frame: u32) -> Option<f32> {
        self.log.get(frame as usize).copied().flatten().map(f32::exp)
    }
}

/// Rounds of weighing.
const ROUNDS: usize = 12;

/// Finds the gains of `frames` frames. Those that are `known` stay as they are; the others are tied to them, or, if none is
/// known, to a median of 0. A missing entry of `known` is an unknown gain.
pub fn gains(sightings: &[Sighting], frames: usize, known: &[Option<f32>]) -> Gains {
    let known = |frame: usize| known.get(frame).copied().flatten();
    let rows = rows(sightings, frames);
    let anchors: Vec<usize> = (0..frames).filter(|&frame| known(frame).is_some()).collect();
    let tied = tied(&rows, frames, &anchors);
    let mut log: Vec<f64> = (0..frames).map(|frame| known(frame).map_or(0.0, f64::from)).collect();
    let free: Vec<bool> = (0..frames).map(|frame| tied[frame] && known(frame).is_none()).collect();
    let rows: Vec<Row> = rows.into_iter().filter(|row| tied[row.frame]).collect();
    let mut weights: Vec<f64> = rows.iter().map(|row| row.share).collect();
    let mut residual = 0.0;
    for _ in 0..ROUNDS {
        solve(&rows, &weights, &free, &mut log);
        let off = residuals(&rows, &weights, &log);
        residual = weigh(&rows, &off, &mut weights);
    }
    if anchors.is_empty() {
        let mut all: Vec<f64> = (0..frames).filter(|&frame| tied[frame]).map(|frame| log[frame]).collect();
        all.sort_unstable_by(f64::total_cmp);
        let middle = all.get(all.len() / 2).copied().unwrap_or(0.0);
        log.iter_mut().for_each(|log| *log -= middle);
    }
    let told = |frame: usize| known(frame).or_else(|| tied[frame].then(|| to_f32(log[frame])));
    Gains { log: (0..frames).map(told).collect(), residual: to_f32(residual) }
}

/// For each row, the weighted mean of a quantity over the rows of its triangle, taken off.
fn less_mean(rows: &[Row], weights: &[f64], quantity: impl Fn(&Row) -> f64, mut out: impl FnMut(usize, f64)) {
    let mut at = 0;
    for of_one in rows.chunk_by(|a, b| a.triangle == b.triangle) {
        let weights = &weights[at..at + of_one.len()];
        let (mut sum, mut weight) = (0.0, 0.0);
        for (row, w) in of_one.iter().zip(weights) {
            sum += w * quantity(row);
            weight += w;
        }
        let mean = if weight > 0.0 { sum / weight } else { 0.0 };
        of_one.iter().enumerate().for_each(|(i, row)| out(at + i, quantity(row) - mean));
        at += of_one.len();
    }
}

/// What the gains leave of each row.
fn residuals(rows: &[Row], weights: &[f64], log: &[f64]) -> Vec<f64> {
    let mut off = vec![0.0; rows.len()];
    less_mean(rows, weights, |row| row.log - log[row.frame], |i, value| off[i] = value);
    off
}

/// Moves the gains of the free frames to the weighted least squares, by conjugate gradients with the diagonal as
/// preconditioner. Where nothing is known, gains are found up to a common one.
fn solve(rows: &[Row], weights: &[f64], free: &[bool], log: &mut [f64]) {
    let frames = log.len();
    let gather = |quantity: &dyn Fn(&Row) -> f64| {
        let mut sums = vec![0.0; frames];
        less_mean(rows, weights, quantity, |i, value| sums[rows[i].frame] += weights[i] * value);
        sums.iter_mut().zip(free).filter(|(_, free)| !**free).for_each(|(sum, _)| *sum = 0.0);
        sums
    };
    let mut diagonal = vec![0.0; frames];
    rows.iter().zip(weights).for_each(|(row, weight)| diagonal[row.frame] += weight);
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(a, b)| a * b).sum::<f64>();
    let eased = |r: &[f64]| -> Vec<f64> { r.iter().zip(&diagonal).map(|(r, d)| r / d.max(1e-12)).collect() };
    let mut rest = gather(&|row| row.log - log[row.frame]);
    let mut step = eased(&rest);
    let mut size = dot(&rest, &step);
    let enough = 1e-16 * (size + diagonal.iter().sum::<f64>() * 1e-6);
    for _ in 0..(4 * frames).clamp(20, 400) {
        if size <= enough {
            break;
        }
        let image = gather(&|row| step[row.frame]);
        let curvature = dot(&step, &image);
        if curvature <= 0.0 {
            break;
        }
        let by = size / curvature;
        log.iter_mut().zip(&step).for_each(|(log, step)| *log += by * step);
        rest.iter_mut().zip(&image).for_each(|(rest, image)| *rest -= by * image);
        let next = eased(&rest);
        let grown = dot(&rest, &next);
        step.iter_mut().zip(&next).for_each(|(step, next)| *step = next + grown / size * *step);
        size = grown;
    }
}
