use super::*;

fn samples(seed: u64, n: u64) -> Vec<Sample> {
    let steps = srgb_steps();
    (0..n).map(|i| Sample::draw(seed, i, &steps)).collect()
}

#[test]
fn records_are_the_same_whatever_writes_them() {
    let (mut whole, mut piecewise) = (Vec::new(), Vec::new());
    let one = rayon::ThreadPoolBuilder::new().num_threads(1).build().unwrap();
    one.install(|| write(&mut whole, 5, 100)).unwrap();
    samples(5, 100).iter().for_each(|s| s.append_to(&mut piecewise));
    assert_eq!(whole.len(), 100 * RECORD);
    assert!(whole == piecewise);
    assert_ne!(samples(5, 3), samples(6, 3));
}

#[test]
fn bins_ascend_in_front_and_radiance_is_clipped() {
    for s in samples(1, 2000) {
        assert!((FEWEST..=SLOTS).contains(&s.bins.len()));
        assert!(s.bins.is_sorted_by(|a, b| a.0 < b.0));
        assert!(s.bins.iter().all(|b| usize::from(b.0) < FRONT_BINS && b.1.iter().all(|v| (0.0..=1.0).contains(v))));
        assert!((s.light.length() - 1.0).abs() < 1e-5 && s.light.z >= 0.05);
    }
}

#[test]
fn maps_are_as_sparse_as_measured_ones() {
    // Two real scenes: 5, 25, 50, 75, 95 % of triangles fill at most 5 8 12 17 28 and 5 10 16 27 47 bins.
    let mut counts: Vec<usize> = samples(2, 4000).iter().map(|s| s.bins.len()).collect();
    counts.sort_unstable();
    let at = |q: usize| counts[counts.len() * q / 100];
    assert!((3..=5).contains(&at(5)), "{}", at(5));
    assert!((12..=18).contains(&at(50)), "{}", at(50));
    assert!((40..=SLOTS).contains(&at(95)), "{}", at(95));
}

#[test]
fn eight_bits_err_by_half_a_step_at_most() {
    let steps = srgb_steps();
    assert_eq!((steps[0], steps[65_535]), (0.0, 1.0));
    for (i, v) in steps.iter().enumerate() {
        assert!((v - i as f32 / 65_535.0).abs() < 0.005, "{i}");
    }
}
