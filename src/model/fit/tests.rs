use glam::Vec3;
use rand::{Rng, RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::Fit;
use crate::model::estimator::{Estimate, Estimator, MapLight};
use crate::scene::Material as M;

use crate::scene::brdf;
use crate::scene::light::LocalLight;
use crate::scene::reflectance::{Bin, BinSum, SparseMap, bin_of};

/// A map as a flight fills it: views spread over 5 to 75 degrees of theta and all azimuths, one to
/// a bin, noise of a step of 8 bits in sRGB's curve, clipped at 1.
fn map(rng: &mut Pcg64Mcg, m: &M, light: &LocalLight, bins: usize) -> SparseMap {
    let mut all: Vec<(Bin, BinSum)> = Vec::new();
    while all.len() < bins {
        let (theta, phi) = (rng.random_range(5f32..75.0).to_radians(), rng.random_range(0.0..std::f32::consts::TAU));
        let wo = Vec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        let bin = bin_of(wo);
        if all.iter().any(|(other, _)| *other == bin) {
            continue;
        }
        let sun = light.sun * brdf::radiance(m, light.direction, wo);
        let sky = light.sky * (Vec3::from(m.kd) + Vec3::from(m.ks) * brdf::sky_specular(m.r, wo.z));
        let sent = sun + sky;
        let step = sent.max(Vec3::ZERO).map(|l| 2.4 / 1.055 / 255.0 * l.powf(1.4 / 2.4));
        let told = sent + step * Vec3::from_array([0; 3].map(|_| noise(rng)));
        let clipped = told.max_element() > 1.0;
        all.push((bin, BinSum::one(told.clamp(Vec3::ZERO, Vec3::ONE).to_array(), clipped)));
    }
    all.sort_unstable_by_key(|(bin, _)| *bin);
    SparseMap { bins: all }
}

/// A number of about the normal distribution.
fn noise(rng: &mut impl Rng) -> f32 {
    (0..12).map(|_| rng.random::<f32>()).sum::<f32>() - 6.0
}

fn light(rng: &mut Pcg64Mcg) -> LocalLight {
    let (z, phi) = (rng.random_range(0.1f32..1.0), rng.random_range(0.0..std::f32::consts::TAU));
    let s = (1.0 - z * z).sqrt();
    LocalLight { direction: Vec3::new(s * phi.cos(), s * phi.sin(), z), sun: Vec3::ONE, sky: Vec3::ZERO }
}

/// How far the fit is off.
#[derive(Debug)]
struct Errors {
    /// Mean absolute errors of kd, ks and r.
    material: [f32; 3],
    /// PSNR of what is relit, of all materials together, dB.
    psnr: f64,
    /// Mean of the PSNRs of the single materials, dB.
    each: f64,
}

/// Mean squared error of what is sent towards 64 directions, spread evenly over the front, under a sun, clipped at 1.
fn relit(rng: &mut Pcg64Mcg, truth: &M, found: &M, sun: Vec3) -> f64 {
    let off = |_| {
        let (z, phi) = (rng.random_range(0.01f32..1.0), rng.random_range(0.0..std::f32::consts::TAU));
        let s = (1.0 - z * z).sqrt();
        let wo = Vec3::new(s * phi.cos(), s * phi.sin(), z);
        let [wanted, found] = [truth, found].map(|m| brdf::radiance(m, sun, wo).min(Vec3::ONE));
        f64::from((wanted - found).length_squared())
    };
    (0..64).map(off).sum::<f64>() / (64.0 * 3.0)
}

/// Errors over random materials, relit under random suns; `wrong` changes the light that the fit is told.
fn errors(bins: usize, sky: Vec3, wrong: impl Fn(LocalLight) -> LocalLight) -> Errors {
    let mut rng = Pcg64Mcg::seed_from_u64(bins as u64);
    let mut novel = Pcg64Mcg::seed_from_u64(1);
    let mut session = Fit::new(None).session().unwrap();
    let (mut sums, mut squares, mut each) = ([0.0; 3], 0.0, 0.0);
    let count = 1000;
    for _ in 0..count {
        let truth = M::from(std::array::from_fn(|_| rng.random::<f32>()));
        let light = LocalLight { sky, ..light(&mut rng) };
        let map = map(&mut rng, &truth, &light, bins);
        let mut found = [Estimate::default()];
        session.estimate(&[&map], Some(&[wrong(light).into()]), &mut found).unwrap();
        let off: Vec<f32> =
            truth.to_array().iter().zip(found[0].material.to_array()).map(|(a, b)| (a - b).abs()).collect();
        sums[0] += off[..3].iter().sum::<f32>() / 3.0;
        sums[1] += off[3..6].iter().sum::<f32>() / 3.0;
        sums[2] += off[6];
        let sun = self::light(&mut novel).direction;
        let squared = relit(&mut novel, &truth, &found[0].material, sun);
        squares += squared / f64::from(count);
        each -= 10.0 * squared.log10() / f64::from(count);
    }
    Errors { material: sums.map(|s| s / count as f32), psnr: -10.0 * squares.log10(), each }
}

#[test]
fn materials_under_a_known_sun_come_back() {
    for (bins, most, psnr, each) in [
        (8, [0.0055, 0.2, 0.175], 30.3, 40.0),
        (16, [0.0035, 0.148, 0.11], 33.0, 43.5),
        (64, [0.002, 0.11, 0.0505], 38.5, 51.0),
    ] {
        let found = errors(bins, Vec3::ZERO, |light| light);
        println!("{bins} bins: {found:?}");
        assert!(found.material.iter().zip(most).all(|(found, most)| *found < most), "{bins} bins: {found:?}");
        assert!(found.psnr > psnr && found.each > each, "{bins} bins: {found:?}");
    }
}

/// Seen in few directions, a matt surface may as well be a smooth one whose highlight was missed.
#[test]
fn matt_surfaces_relight_no_worse_than_lambertians() {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let light = LocalLight { direction: Vec3::new(0.68, 0.0, 0.73), sun: Vec3::ONE, sky: Vec3::new(0.16, 0.19, 0.24) };
    let white = light.sun * light.direction.z + light.sky;
    let mut session = Fit::new(None).session().unwrap();
    for bins in [2, 5, 10, 20, 40] {
        let mut squares = [0.0; 2];
        for _ in 0..200 {
            let (kd, ks, r) = (rng.random_range(0.05..0.4), rng.random_range(0.05..0.25), rng.random_range(0.65..0.9));
            let truth = M { kd: [kd; 3], ks: [ks; 3], r };
            let map = map(&mut rng, &truth, &light, bins);
            let mut found = [Estimate::default()];
            session.estimate(&[&map], Some(&[light.into()]), &mut found).unwrap();
            let mean = map.bins.iter().map(|(_, sum)| Vec3::from(sum.mean())).sum::<Vec3>() / bins as f32;
            let lambertian = M { kd: (mean / white).to_array(), ks: [0.0; 3], r };
            let low = Vec3::new(-0.47, 0.814, 0.342);
            for (sum, m) in squares.iter_mut().zip([&found[0].material, &lambertian]) {
                *sum += relit(&mut rng, &truth, m, low);
            }
        }
        println!("{bins} bins: fit {:.2e}, Lambertian {:.2e}", squares[0], squares[1]);
        assert!(squares[0] < squares[1], "{bins} bins: {squares:?}");
    }
}

#[test]
fn a_sun_three_degrees_off_is_borne() {
    let turned = |light: LocalLight| {
        let axis = light.direction.any_orthonormal_vector();
        let direction = glam::Quat::from_axis_angle(axis, 3f32.to_radians()) * light.direction;
        LocalLight { direction, ..light }
    };
    let found = errors(16, Vec3::new(0.16, 0.19, 0.24), turned);
    println!("3 degrees off: {found:?}");
    assert!(found.material.iter().zip([0.025, 0.138, 0.114]).all(|(found, most)| *found < most), "{found:?}");
}

#[test]
fn shadow_and_nothing_fall_back_on_a_matt_prior() {
    let mut session = Fit::new(None).session().unwrap();
    let dark = LocalLight { direction: Vec3::Z, sun: Vec3::ZERO, sky: Vec3::ZERO };
    let map = SparseMap { bins: vec![(5, BinSum::one([0.0; 3], false))] };
    let mut found = [Estimate::default(); 2];
    session.estimate(&[&map, &SparseMap::default()], Some(&[dark.into(), dark.into()]), &mut found).unwrap();
    for Estimate { material: m, deviation } in found {
        assert!(deviation.iter().all(|d| (0.15..0.3).contains(d)), "{deviation:?}");
        assert!(m.kd == [0.25; 3] && m.ks.iter().all(|ks| *ks < 0.11) && (m.r - 0.75).abs() < 1e-3, "{m:?}");
    }
    // Under the sky alone a matt surface is as bright as it is white.
    let sky = LocalLight { sky: Vec3::splat(0.2), ..dark };
    let truth = M { kd: [0.2, 0.5, 0.8], ks: [0.0; 3], r: 0.5 };
    let rgb = (Vec3::from(truth.kd) * 0.2).to_array();
    let map = SparseMap { bins: (0..8).map(|i| (i * 240, BinSum::one(rgb, false))).collect() };
    session.estimate(&[&map], Some(&[sky.into()]), &mut found[..1]).unwrap();
    assert!(found[0].material.kd.iter().zip(truth.kd).all(|(a, b)| (a - b).abs() < 0.06), "{found:?}");
}

#[test]
fn an_outlier_frame_counts_for_little() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let truth = M { kd: [0.3, 0.4, 0.2], ks: [0.2; 3], r: 0.7 };
    let light = LocalLight { direction: Vec3::new(0.6, 0.0, 0.8), sun: Vec3::ONE, sky: Vec3::splat(0.1) };
    let mut map = map(&mut rng, &truth, &light, 16);
    map.bins[7].1 = BinSum::one([0.9, 0.1, 0.1], false);
    let mut found = [Estimate::default()];
    Fit::new(None).session().unwrap().estimate(&[&map], Some(&[light.into()]), &mut found).unwrap();
    assert!(found[0].material.kd.iter().zip(truth.kd).all(|(a, b)| (a - b).abs() < 0.03), "{found:?}");
}

#[test]
fn lights_are_needed() {
    let said = Fit::new(None).session().unwrap().estimate(&[&SparseMap::default()], None, &mut [Estimate::default()]);
    assert!(said.unwrap_err().to_string().contains("as many lights"));
}

/// A half of the triangle in the sun and a half in the shade say together what the mean of both does not.
#[test]
fn sunlit_and_shaded_observations_are_fitted_together() {
    let mut rng = Pcg64Mcg::seed_from_u64(7);
    let truth = M { kd: [0.3, 0.2, 0.1], ks: [0.4; 3], r: 0.4 };
    let direction = Vec3::new(0.48, 0.0, 0.877_268_5);
    let sun = LocalLight { direction, sun: Vec3::ONE, sky: Vec3::splat(0.15) };
    let shade = LocalLight { sun: Vec3::ZERO, ..sun };
    let (lit, dark) = (map(&mut rng, &truth, &sun, 20), map(&mut rng, &truth, &shade, 20));
    let mut all = [lit.bins.clone(), dark.bins.clone()].concat();
    all.sort_unstable_by_key(|(bin, _)| *bin);
    all.dedup_by_key(|(bin, _)| *bin);
    let mixed = SparseMap { bins: all };
    let half = LocalLight { sun: Vec3::splat(0.5), ..sun };
    let mut session = Fit::new(None).session().unwrap();
    let mut off = |parts: &[(&SparseMap, LocalLight)]| -> f32 {
        let mut found = [Estimate::default()];
        session.estimate(&[&mixed], Some(&[MapLight { whole: half, parts }]), &mut found).unwrap();
        let found = found[0].material.to_array();
        truth.to_array().iter().zip(found).map(|(a, b)| (a - b).abs()).sum::<f32>() / 7.0
    };
    let (together, apart) = (off(&[]), off(&[(&lit, sun), (&dark, shade)]));
    assert!(apart < 0.05 && apart < 0.5 * together, "{apart} {together}");
}
