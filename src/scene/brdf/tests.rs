//! Physics: symmetry, energy by quadrature, closed forms, limits. References are worked out in f64 from the formulas.

use std::f32::consts::{FRAC_1_PI, PI};
use std::f64::consts::TAU;

use glam::Vec3;

use super::microfacet::{ETA, evaluate, specular};
use super::*;
use crate::base::convert::to_f32;
use crate::scene::Material;

/// Roughnesses, both ends among them.
const ROUGHNESSES: [f32; 7] = [0.0, 0.05, 0.2, 0.4, 0.6, 0.8, 1.0];

fn lobe(r: f32) -> Material {
    Material { kd: [0.0; 3], ks: [1.0, 0.5, 0.25], r }
}

/// A unit vector by its angles, degrees.
fn direction(theta_deg: f32, phi_deg: f32) -> Vec3 {
    let ((s, c), (sp, cp)) = (theta_deg.to_radians().sin_cos(), phi_deg.to_radians().sin_cos());
    Vec3::new(s * cp, s * sp, c)
}

/// The cosine-weighted integral of `f` over incoming directions, by midpoints over the hemisphere: the directional
/// albedo. Half vectors are what is sampled evenly, as the lobe is narrow in them: wi = reflect(wo, h).
fn lobe_albedo(alpha: f32, wo: Vec3) -> f64 {
    let (rings, sectors) = (600, 240);
    let mut sum = 0.0;
    for i in 0..rings {
        // tan(theta_h) = alpha sqrt(u / (1 - u)) has the density D cos, which the quadrature divides by.
        let u = (f64::from(i) + 0.5) / f64::from(rings);
        let tan = f64::from(alpha) * (u / (1.0 - u)).sqrt();
        let cos = 1.0 / (1.0 + tan * tan).sqrt();
        for j in 0..sectors {
            let phi = TAU * (f64::from(j) + 0.5) / f64::from(sectors);
            let h = glam::DVec3::new(tan * cos * phi.cos(), tan * cos * phi.sin(), cos);
            let o = wo.as_dvec3();
            let wi = h * (2.0 * o.dot(h)) - o;
            if o.dot(h) <= 0.0 || wi.z <= 0.0 {
                continue;
            }
            let (a2, c2) = (f64::from(alpha).powi(2), cos * cos);
            let density = a2 / (std::f64::consts::PI * (c2 * (a2 - 1.0) + 1.0).powi(2)) * cos;
            // The Jacobian of the reflection is 4 wo.h.
            let f = f64::from(specular(alpha, wi.as_vec3(), wo));
            sum += f * wi.z * 4.0 * o.dot(h) / density;
        }
    }
    sum / f64::from(rings * sectors)
}

#[test]
fn light_goes_both_ways_alike() {
    for r in ROUGHNESSES {
        let m = Material { kd: [0.2, 0.4, 0.6], ..lobe(r) };
        for (a, b) in [(0.0, 89.0), (10.0, 10.1), (30.0, 60.0), (85.0, 86.0), (45.0, 45.0)] {
            for turn in [0.0, 77.0, 180.0] {
                let (wi, wo) = (direction(a, 0.0), direction(b, turn));
                let (there, back) = (evaluate(&m, wi, wo), evaluate(&m, wo, wi));
                assert!((there - back).abs().max_element() <= 1e-5 * there.max_element(), "r {r}: {there} {back}");
            }
        }
    }
}

#[test]
fn the_diffuse_part_gives_kd() {
    let m = Material { kd: [0.1, 0.5, 0.9], ks: [0.0; 3], r: 0.3 };
    // A constant: pi times it is the albedo.
    for theta in [0.0, 40.0, 89.0] {
        let f = evaluate(&m, direction(theta, 10.0), direction(70.0, 200.0));
        assert!((f * PI - Vec3::from(m.kd)).abs().max_element() < 1e-6);
    }
}

#[test]
fn the_lobe_alone_never_gives_more_than_ks() {
    for r in ROUGHNESSES {
        let alpha = lobe(r).alpha();
        for theta in [0.0, 30.0, 60.0, 80.0, 88.0] {
            let albedo = lobe_albedo(alpha, direction(theta, 0.0));
            assert!(albedo > 0.0 && albedo <= 1.0 + 1e-4, "r {r}, {theta} degrees: {albedo}");
        }
    }
    // A smooth one gives what Fresnel says.
    for theta in [0.0, 40.0, 70.0] {
        let (wo, alpha) = (direction(theta, 0.0), lobe(0.0).alpha());
        let albedo = lobe_albedo(alpha, wo);
        assert!((albedo / f64::from(fresnel(wo.z)) - 1.0).abs() < 0.01, "{theta} degrees: {albedo}");
    }
}

#[test]
fn the_distribution_projects_to_one() {
    for r in ROUGHNESSES {
        let alpha = lobe(r).alpha();
        // Over theta, with t = tan: D cos^4 t dt 2 pi, substituted by t = alpha s, s = x / (1 - x).
        let n = 20_000;
        let sum: f64 = (0..n)
            .map(|k| {
                let x = (f64::from(k) + 0.5) / f64::from(n);
                let (s, ds) = (x / (1.0 - x), 1.0 / (1.0 - x).powi(2));
                let t = f64::from(alpha) * s;
                let c2 = 1.0 / (1.0 + t * t);
                let d = f64::from(distribution(alpha, to_f32(c2), to_f32(t * t * c2)));
                TAU * d * c2 * c2 * t * f64::from(alpha) * ds
            })
            .sum();
        assert!((sum / f64::from(n) - 1.0).abs() < 1e-3, "r {r}: {}", sum / f64::from(n));
    }
}

#[test]
fn fresnel_has_its_closed_forms() {
    let close = |a: f32, b: f64| assert!((f64::from(a) - b).abs() < 1e-6, "{a} {b}");
    close(fresnel(1.0), 0.04);
    close(fresnel(0.0), 1.0);
    // At Brewster's angle, tan = eta, only the perpendicular part is left: ((eta^2 - 1) / (eta^2 + 1))^2 / 2.
    let eta2 = f64::from(ETA).powi(2);
    let brewster = 1.0 / (1.0 + eta2).sqrt();
    close(fresnel(to_f32(brewster)), 0.5 * ((eta2 - 1.0) / (eta2 + 1.0)).powi(2));
    // Snell and Fresnel as they are in textbooks: sines and tangents of the two angles.
    for degrees in [5.0f64, 30.0, 50.0, 75.0, 89.0] {
        let i = degrees.to_radians();
        let t = (i.sin() / f64::from(ETA)).asin();
        let (s, p) = ((i - t).sin() / (i + t).sin(), (i - t).tan() / (i + t).tan());
        close(fresnel(to_f32(i.cos())), 0.5 * (s * s + p * p));
    }
}

#[test]
fn normal_incidence_has_a_closed_form() {
    // wi = wo = n: D = 1 / (pi a^2), G = 1, F = 0.04.
    for r in ROUGHNESSES {
        let m = lobe(r);
        let a = f64::from(m.alpha());
        let expected = 0.04 / (std::f64::consts::PI * a * a) / 4.0;
        let found = evaluate(&m, Vec3::Z, Vec3::Z);
        assert!((f64::from(found.x) / expected - 1.0).abs() < 1e-4, "r {r}: {found}");
        assert!((found.y / found.x - 0.5).abs() < 1e-6 && (found.z / found.x - 0.25).abs() < 1e-6);
    }
}

#[test]
fn any_angle_agrees_with_the_formula_in_f64() {
    let reference = |a: f64, wi: glam::DVec3, wo: glam::DVec3| {
        let h = (wi + wo).normalize();
        let d = a * a / (std::f64::consts::PI * (h.z * h.z * (a * a - 1.0) + 1.0).powi(2));
        let smith = |c: f64| 0.5 * ((1.0 + a * a * (1.0 - c * c) / (c * c)).sqrt() - 1.0);
        let (c, t) = (wi.dot(h), (1.0 - (1.0 - wi.dot(h).powi(2)) / 2.25).sqrt());
        let f = 0.5 * (((1.5 * c - t) / (1.5 * c + t)).powi(2) + ((c - 1.5 * t) / (c + 1.5 * t)).powi(2));
        d * f / ((1.0 + smith(wi.z) + smith(wo.z)) * 4.0 * wi.z * wo.z)
    };
    for r in [0.3, 0.5, 0.9] {
        let alpha = lobe(r).alpha();
        for (a, b, turn) in [(20.0, 35.0, 0.0), (60.0, 58.0, 175.0), (80.0, 10.0, 90.0), (45.0, 45.0, 180.0)] {
            let (wi, wo) = (direction(a, 0.0), direction(b, turn));
            let (found, expected) =
                (specular(alpha, wi, wo), reference(f64::from(alpha), wi.as_dvec3(), wo.as_dvec3()));
            assert!((f64::from(found) / expected - 1.0).abs() < 2e-3, "r {r}, {a} {b} {turn}: {found} {expected}");
        }
    }
}

#[test]
fn roughness_has_its_limits() {
    assert_eq!(lobe(0.0).alpha(), 1e-3);
    assert_eq!(lobe(1.0).alpha(), 1.0);
    assert_eq!(lobe(0.5).alpha(), 0.25);
    // At alpha = 1 facets lie evenly: D is 1 / pi whatever the half vector.
    for cos2 in [0.0, 0.3, 1.0] {
        assert!((distribution(1.0, cos2, 1.0 - cos2) - FRAC_1_PI).abs() < 1e-6);
    }
    // A mirror's lobe is far below its peak a degree aside.
    let peak = evaluate(&lobe(0.0), direction(30.0, 0.0), direction(30.0, 180.0)).x;
    assert!(evaluate(&lobe(0.0), direction(30.0, 0.0), direction(32.0, 180.0)).x < 1e-3 * peak);
}

#[test]
fn radiance_is_pi_times_the_cosine_times_the_brdf() {
    let m = Material { kd: [0.3, 0.6, 0.9], ..lobe(0.5) };
    let (wi, wo) = (direction(50.0, 20.0), direction(35.0, 190.0));
    assert!((radiance(&m, wi, wo) - PI * evaluate(&m, wi, wo) * wi.z).abs().max_element() < 1e-6);
    let white = Material { kd: [1.0; 3], ks: [0.0; 3], r: 1.0 };
    assert!((radiance(&white, Vec3::Z, wo) - Vec3::ONE).abs().max_element() < 1e-6);
}

#[test]
fn below_the_surface_there_is_nothing_and_nowhere_a_nan() {
    let angles = [0.0, 45.0, 89.0, 89.999, 90.0, 90.001, 135.0, 180.0];
    for r in ROUGHNESSES {
        let m = Material { kd: [1.0; 3], ..lobe(r) };
        for (a, b) in angles.into_iter().flat_map(|a| angles.map(|b| (a, b))) {
            for turn in [0.0, 90.0, 180.0] {
                let (wi, wo) = (direction(a, 0.0), direction(b, turn));
                let (f, sent) = (evaluate(&m, wi, wo), radiance(&m, wi, wo));
                assert!(
                    f.is_finite() && sent.is_finite() && f.min_element() >= 0.0,
                    "r {r}, {a} {b} {turn}: {f} {sent}"
                );
                if wi.z <= 0.0 || wo.z <= 0.0 {
                    assert_eq!((f, sent), (Vec3::ZERO, Vec3::ZERO));
                }
            }
        }
    }
}
