//! The scale, which photographs cannot tell: a brighter sun looks like whiter walls. It is a convention about the albedo of lit
//! surfaces.

use super::comparison::{Comparison, albedo};
use super::observed::luma;
use super::ratio::Ratio;

/// The upper quantile of albedo, by area, and its value over scenes.
const QUANTILE: f64 = 0.95;
const UPPER: f32 = 0.34;

/// How far a scene's albedo lies from the convention: a factor of 1.25.
pub(super) const SPREAD: f32 = 0.22;

/// The least share of the sun that makes a patch lit.
const LIT: f32 = 0.2;

/// The radiance of a white surface that faces the sun, if lit surfaces are as white as surfaces mostly are.
pub(super) fn white(comparison: &Comparison<'_>, lit: &[f32], ratio: Ratio) -> f32 {
    let mut found: Vec<(f32, f32)> = Vec::new();
    for ((patch, &ambient), &lit) in comparison.patches.all.iter().zip(&comparison.ambient).zip(lit) {
        if lit > LIT {
            let channel = |c: usize| albedo(patch.radiance[c], ambient, lit, ratio[c], comparison.white);
            found.push((luma([channel(0), channel(1), channel(2)]), patch.area));
        }
    }
    found.sort_by(|a, b| a.0.total_cmp(&b.0));
    let all: f64 = found.iter().map(|(_, area)| f64::from(*area)).sum();
    let mut sum = 0.0;
    let at = found.iter().find(|(_, area)| {
        sum += f64::from(*area);
        sum >= QUANTILE * all
    });
    at.map_or(comparison.white, |(albedo, _)| comparison.white * albedo / UPPER)
}
