//! Weights of sightings of which some do not fit, such as highlights and what moved (Geman and McClure).

use super::rows::Row;

/// The residual, in standard deviations, at which a sighting counts for a quarter.
const FAR: f64 = 2.0;

/// The smallest standard deviation that is believed.
const FLOOR: f64 = 0.01;

/// Weighs rows by what is left of each. Returns the standard deviation of that without outliers, from its median.
pub(super) fn weigh(rows: &[Row], left: &[f64], weights: &mut [f64]) -> f64 {
    let mut sizes: Vec<f64> = left.iter().map(|left| left.abs()).collect();
    sizes.sort_unstable_by(f64::total_cmp);
    let deviation = 1.4826 * sizes.get(sizes.len() / 2).copied().unwrap_or(0.0);
    let far = FAR * deviation.max(FLOOR);
    for ((weight, left), row) in weights.iter_mut().zip(left).zip(rows) {
        *weight = row.share / (1.0 + (left / far).powi(2)).powi(2);
    }
    deviation
}
