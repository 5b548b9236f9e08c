use super::*;

const PRIORS: [Prior; 3] = [Prior::Uniform, Prior::Outdoor, Prior::Mixed];

fn samples(prior: Prior, seed: u64, n: u64) -> Vec<Sample> {
    let steps = srgb_steps();
    (0..n).map(|i| Sample::draw(prior, seed, i, &steps)).collect()
}

#[test]
fn samples_are_the_same_whatever_writes_them() {
    let (mut whole, mut piecewise) = (Vec::new(), Vec::new());
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    one.install(|| write(&mut whole, Prior::Uniform, 5, 100)).unwrap();
    samples(Prior::Uniform, 5, 100).iter().for_each(|s| s.append_to(&mut piecewise));
    assert_eq!(whole.len(), 100 * SAMPLE);
    assert!(whole == piecewise);
    assert_ne!(samples(Prior::Uniform, 5, 3), samples(Prior::Uniform, 6, 3));
}

#[test]
fn bins_ascend_in_front_and_radiance_is_clipped() {
    for s in PRIORS.iter().flat_map(|prior| samples(*prior, 1, 2000)) {
        assert!((FEWEST..=SLOTS).contains(&s.bins.len()));
        assert!(s.bins.is_sorted_by(|a, b| a.0 < b.0));
        assert!(s.bins.iter().all(|b| usize::from(b.0) < FRONT_BINS && b.1.iter().all(|v| (0.0..=1.0).contains(v))));
        let LocalLight { direction, sun, sky } = s.light;
        assert!((direction.length() - 1.0).abs() < 1e-5 && (direction.z > 0.0 || sun == Vec3::ZERO));
        assert!(sun == Vec3::ZERO || sun == Vec3::ONE);
        assert!(sky.min_element() >= 0.0 && sky.max_element() <= 0.3);
        assert!(s.material.to_array().iter().all(|v| (0.0..=1.0).contains(v)));
    }
}

#[test]
fn maps_are_as_sparse_as_measured_ones() {
    // Two real scenes: 5, 25, 50, 75, 95 % of triangles fill at most 5 8 12 17 28 and 5 10 16 27 47 bins.
    for prior in PRIORS {
        let mut counts: Vec<usize> = samples(prior, 2, 4000).iter().map(|s| s.bins.len()).collect();
        counts.sort_unstable();
        let at = |q: usize| counts[counts.len() * q / 100];
        assert!((3..=5).contains(&at(5)), "{}", at(5));
        assert!((12..=18).contains(&at(50)), "{}", at(50));
        assert!((40..=SLOTS).contains(&at(95)), "{}", at(95));
    }
}

#[test]
fn outdoors_is_darker_and_duller_than_anything() {
    let mean = |prior, of: fn(&Sample) -> f32| {
        let all = samples(prior, 3, 4000);
        all.iter().map(of).sum::<f32>() / all.len() as f32
    };
    for of in [(|s| s.material.kd[1]) as fn(&Sample) -> f32, |s| s.material.ks[1], |s| s.light.sun.x] {
        let (any, outdoors) = (mean(Prior::Uniform, of), mean(Prior::Outdoor, of));
        assert!(outdoors < any - 0.05, "{outdoors} {any}");
    }
}

#[test]
fn eight_bits_err_by_half_a_step_at_most() {
    let steps = srgb_steps();
    assert_eq!((steps[0], steps[65_535]), (0.0, 1.0));
    for (i, v) in steps.iter().enumerate() {
        assert!((v - i as f32 / 65_535.0).abs() < 0.005, "{i}");
    }
}
