//! The scale, which photographs cannot tell: a brighter light looks like whiter walls. It is a convention about the albedo of
//! lit surfaces.

use super::comparison::Comparison;
use super::observed::luma;
use super::patches::Patch;
use super::ratio::Ratio;

/// The upper quantile of albedo, by area, and its value over scenes.
const QUANTILE: f64 = 0.95;
const UPPER: f32 = 0.34;

/// How far a scene's albedo lies from the convention: a factor of 1.25.
pub(super) const SPREAD: f32 = 0.22;

/// The least cosine of the sun on a patch, times its share, that makes a patch lit.
const LIT: f32 = 0.2;

/// The least share of the sky that a patch sees, where the sky is all its light.
const OPEN: f32 = 0.3;

/// The factor by which scenes' upper quantiles of albedo differ: within it, photographs are taken at their word.
const USUAL: f32 = 1.35;

/// The radiance of a white surface that faces the sun. It is the photographs' own white, 1, if that makes lit surfaces about as
/// white as surfaces mostly are, else the radiance that makes them so.
pub(super) fn white(comparison: &Comparison<'_>, lit: &[f32], ratio: Ratio) -> f32 {
    let found = of_patches(comparison, lit, ratio, |_, lit| lit > LIT);
    if (1.0 / USUAL..USUAL).contains(&found) { 1.0 } else { found }
}

/// The radiance of a white surface under the whole sky, where there is no sun.
pub(super) fn overcast(comparison: &Comparison<'_>) -> f32 {
    of_patches(comparison, &vec![0.0; comparison.patches.all.len()], [1.0; 3], |patch, _| patch.sky > OPEN)
}

fn of_patches(comparison: &Comparison<'_>, lit: &[f32], ratio: Ratio, takes: impl Fn(&Patch, f32) -> bool) -> f32 {
    let mut found: Vec<(f32, f32)> = Vec::new();
    for (at, (patch, &lit)) in comparison.patches.all.iter().zip(lit).enumerate() {
        if takes(patch, lit) {
            found.push((luma(comparison.albedo(at, lit, ratio)), patch.area));
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
