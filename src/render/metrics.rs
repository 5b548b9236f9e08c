//! The errors of estimated materials against the truth.

use crate::base::{Error, Result};
use crate::scene::Material;

/// The mean of the priors that estimators are trained on: the best constant guess before anything is seen.
pub(crate) const TRAINING_MEAN: Material = Material { kd: [0.5; 3], ks: [0.5; 3], r: 0.5 };

/// The shares of kd's components, of ks's components and of roughnesses that lie within one deviation of the truth, over
/// the seen triangles that have a deviation; `None` if no triangle has one.
pub(crate) fn within(
    truth: &[Material],
    estimate: &[Material],
    deviation: &[[f32; Material::LEN]],
    seen: &[bool],
) -> Option<[f64; 3]> {
    let (mut counts, mut all) = ([0u64; 3], 0u64);
    for (((t, e), d), _) in truth.iter().zip(estimate).zip(deviation).zip(seen).filter(|(_, seen)| **seen) {
        let (t, e) = (t.to_array(), e.to_array());
        if d.iter().chain(&t).any(|v| !v.is_finite()) {
            continue;
        }
        (0..Material::LEN).filter(|&c| (t[c] - e[c]).abs() <= d[c]).for_each(|c| counts[c / 3] += 1);
        all += 1;
    }
    (all > 0).then(|| [0, 1, 2].map(|i| counts[i] as f64 / (all * if i == 2 { 1 } else { 3 }) as f64))
}

/// Mean absolute errors of materials, over triangles and over the three channels of kd and ks.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct MaterialErrors {
    /// The error of the diffuse albedo.
    pub kd: f64,
    /// The error of the specular scale.
    pub ks: f64,
    /// The error of the roughness.
    pub r: f64,
    /// Triangles compared.
    pub count: u64,
    /// Seen triangles without an estimate (a component is not finite); the means leave these triangles out.
    pub missing: u64,
}

/// Compares an estimate with the truth over the triangles where `seen` is true. A triangle whose estimate has a component
/// that is not finite counts as missing; one whose truth has such a component, as where a pane mirrors, is left out. Means are NaN where no triangle was compared.
///
/// # Errors
/// The lists differ in length.
pub(crate) fn compare(truth: &[Material], estimate: &[Material], seen: &[bool]) -> Result<MaterialErrors> {
    same_length("triangles of the truth", truth.len(), "of the estimate", estimate.len())?;
    same_length("triangles of the truth", truth.len(), "in the list of seen ones", seen.len())?;
    let (mut sums, mut count, mut missing) = ([0.0_f64; Material::LEN], 0_u64, 0_u64);
    for ((t, e), _) in truth.iter().zip(estimate).zip(seen).filter(|(_, seen)| **seen) {
        let (t, e) = (t.to_array(), e.to_array());
        if t.iter().any(|v| !v.is_finite()) {
            continue;
        }
        if e.iter().any(|v| !v.is_finite()) {
            missing += 1;
            continue;
        }
        count += 1;
        for (sum, (a, b)) in sums.iter_mut().zip(t.into_iter().zip(e)) {
            *sum += (f64::from(a) - f64::from(b)).abs();
        }
    }
    let mean = |from: usize, to: usize| sums[from..to].iter().sum::<f64>() / ((to - from) as f64 * count as f64);
    Ok(MaterialErrors { kd: mean(0, 3), ks: mean(3, 6), r: mean(6, 7), count, missing })
}

/// The trivial guess from the observations: mean radiance as diffuse albedo (at most 1), no specular part, middling
/// roughness. Where the mean is not finite the guess is not, and counts as missing.
pub(crate) fn diffuse_guess(mean_radiance: &[[f32; 3]]) -> Vec<Material> {
    // `clamp` keeps NaN.
    mean_radiance.iter().map(|m| Material { kd: m.map(|v| v.clamp(0.0, 1.0)), ks: [0.0; 3], r: 0.5 }).collect()
}

fn same_length(first: &str, a: usize, second: &str, b: usize) -> Result<()> {
    if a == b {
        Ok(())
    } else {
        Err(Error::invalid(format!("{a} {first}, but {b} {second}: the two counts must be equal")))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn truths_within_a_deviation_are_counted_by_component() {
        let truth = [Material { kd: [0.5; 3], ks: [0.5; 3], r: 0.5 }; 3];
        let found = [Material { kd: [0.5, 0.6, 0.7], ks: [0.5; 3], r: 0.9 }; 3];
        let deviation = [[0.11; 7], [f32::NAN; 7], [0.5; 7]];
        let [kd, ks, r] = within(&truth, &found, &deviation, &[true; 3]).unwrap();
        assert!((kd - 5.0 / 6.0).abs() < 1e-9 && ks == 1.0 && r == 0.5, "{kd} {ks} {r}");
        assert_eq!(within(&truth, &found, &deviation, &[false, true, false]), None);
    }

    #[test]
    fn errors_are_means_over_seen_triangles_that_have_an_estimate() {
        let truth = [Material { kd: [0.2; 3], ks: [0.4; 3], r: 0.6 }; 4];
        let near = Material { kd: [0.3, 0.2, 0.2], ks: [0.1, 0.4, 0.7], r: 0.5 };
        let none = Material { kd: [0.2; 3], ks: [0.4; 3], r: f32::NAN };
        let far = Material { kd: [1.0; 3], ks: [1.0; 3], r: 0.0 };
        let errors = compare(&truth, &[near, truth[0], none, far], &[true, true, true, false]).unwrap();
        assert_eq!((errors.count, errors.missing), (2, 1));
        assert!((errors.kd - 0.1 / 6.0).abs() < 1e-6, "{errors:?}");
        assert!((errors.ks - 0.6 / 6.0).abs() < 1e-6, "{errors:?}");
        assert!((errors.r - 0.1 / 2.0).abs() < 1e-6, "{errors:?}");
    }

    #[test]
    fn a_truth_that_is_no_number_is_left_out() {
        let clear = Material::from([f32::NAN; Material::LEN]);
        let (truth, found) = ([TRAINING_MEAN, clear], [Material { r: 0.6, ..TRAINING_MEAN }; 2]);
        let errors = compare(&truth, &found, &[true; 2]).unwrap();
        assert!(errors.count == 1 && errors.missing == 0 && (errors.r - 0.1).abs() < 1e-6, "{errors:?}");
        assert_eq!(within(&truth, &found, &[[0.05; 7]; 2], &[true; 2]), Some([1.0, 1.0, 0.0]));
    }

    #[test]
    fn nothing_compared_is_no_perfect_score() {
        let errors = compare(&[TRAINING_MEAN], &[TRAINING_MEAN], &[false]).unwrap();
        assert!(errors.kd.is_nan() && errors.ks.is_nan() && errors.r.is_nan() && errors.count == 0);
        let words = compare(&[TRAINING_MEAN], &[], &[true]).unwrap_err().to_string();
        assert!(words.contains("1 triangles of the truth, but 0 of the estimate"), "{words}");
    }

    #[test]
    fn the_diffuse_guess_stays_a_material() {
        let guess = diffuse_guess(&[[0.25, 1.5, -0.1], [f32::NAN, 0.0, 0.0]]);
        assert_eq!(guess[0], Material { kd: [0.25, 1.0, 0.0], ks: [0.0; 3], r: 0.5 });
        assert!(guess[1].kd[0].is_nan());
    }
}
