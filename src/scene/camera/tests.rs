//! Truth: round trips over whole frames, closed forms by hand, derivatives by differences. Garbage: parameters.

use std::f64::consts::FRAC_PI_2;

use glam::{DVec2, DVec3};

use super::*;

/// Every model as it comes out of real calibrations, of 4000 x 3000 pixels.
fn cameras() -> Vec<Camera> {
    let c = [2010.5, 1488.25];
    let two = |f: [f64; 2], k: &[f64]| [&f, &c, k].concat();
    let one = |f: f64, k: &[f64]| [&[f], &c[..], k].concat();
    [
        ("SIMPLE_PINHOLE", one(3200.0, &[])),
        ("PINHOLE", two([3200.0, 3190.0], &[])),
        ("SIMPLE_RADIAL", one(2900.0, &[-0.07])),
        ("SIMPLE_RADIAL", one(2900.0, &[0.12])),
        ("RADIAL", one(2900.0, &[-0.12, 0.03])),
        ("OPENCV", two([2900.0, 2910.0], &[-0.28, 0.11, 8e-4, -5e-4])),
        ("OPENCV_FISHEYE", two([1500.0, 1505.0], &[0.03, -0.012, 0.004, -0.0009])),
        ("FULL_OPENCV", two([2900.0, 2910.0], &[6.2, 11.0, 4e-4, -3e-4, 0.9, 6.5, 13.0, 3.6])),
        ("FOV", two([2200.0, 2210.0], &[0.92])),
        ("SIMPLE_RADIAL_FISHEYE", one(1500.0, &[-0.02])),
        ("RADIAL_FISHEYE", one(1500.0, &[-0.02, 0.003])),
        ("THIN_PRISM_FISHEYE", two([1500.0, 1490.0], &[0.02, -0.01, 4e-4, -3e-4, 1e-3, -2e-4, 5e-4, -6e-4])),
        (
            "RAD_TAN_THIN_PRISM_FISHEYE",
            two([1400.0, 1410.0], &[0.05, -0.03, 0.012, -0.004, 8e-4, -9e-5, 4e-4, -5e-4, 9e-4, -1e-4, -7e-4, 2e-4]),
        ),
    ]
    .map(|(name, parameters)| Camera::from_colmap(name, 4000, 3000, &parameters).unwrap())
    .to_vec()
}

fn name(camera: &Camera) -> &'static str {
    camera.model.to_colmap().1
}

/// Pixel centres of the whole frame, its corners among them.
fn pixels() -> impl Iterator<Item = DVec2> {
    let along = |n: u32, step: usize| (0..n).step_by(step).chain([n - 1]);
    along(3000, 61).flat_map(move |y| along(4000, 61).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)))
}

#[test]
fn pixels_come_back_from_their_rays_over_the_whole_frame() {
    for camera in cameras() {
        let mut worst = 0.0f64;
        for pixel in pixels() {
            let ray = camera.ray(pixel).unwrap_or_else(|| panic!("{}: no ray at {pixel}", name(&camera)));
            assert!((ray.length() - 1.0).abs() < 1e-12);
            // Any point of the ray is seen there.
            let back = camera.project(ray * 7.0).unwrap_or_else(|| panic!("{}: {pixel} is not seen", name(&camera)));
            worst = worst.max(back.distance(pixel));
        }
        assert!(worst < 1e-6, "{}: {worst} pixels", name(&camera));
    }
}

#[test]
fn rays_come_back_from_their_pixels() {
    for camera in cameras() {
        for (x, y) in [(-0.3, 0.2), (0.1, -0.4), (0.0, 0.0), (1e-12, 0.0)] {
            let ray = DVec3::new(x, y, 1.0).normalize();
            let back = camera.ray(camera.project(ray).unwrap()).unwrap();
            assert!(back.distance(ray) < 1e-10, "{} {ray}: {back}", name(&camera));
        }
    }
}

#[test]
fn single_points_by_hand() {
    let seen = |name: &str, parameters: &[f64], point: DVec3, pixel: (f64, f64)| {
        let camera = Camera::from_colmap(name, 100, 100, parameters).unwrap();
        let found = camera.project(point).unwrap();
        assert!(found.distance(DVec2::from(pixel)) < 1e-9, "{name}: {found}, not {pixel:?}");
    };
    let p = DVec3::new(1.0, 2.0, 4.0); // (0.25, 0.5), r2 = 0.3125
    seen("SIMPLE_PINHOLE", &[100.0, 50.0, 40.0], p, (75.0, 90.0));
    seen("PINHOLE", &[100.0, 200.0, 50.0, 40.0], p, (75.0, 140.0));
    seen("SIMPLE_RADIAL", &[100.0, 50.0, 40.0, 0.32], p, (77.5, 95.0));
    seen("RADIAL", &[100.0, 50.0, 40.0, 0.32, 1.024], p, (80.0, 100.0));
    // p1: (2 x y, r2 + 2 y2) = (0.25, 0.8125); p2: (r2 + 2 x2, 2 x y) = (0.4375, 0.25)
    seen("OPENCV", &[100.0, 100.0, 50.0, 40.0, 0.0, 0.0, 0.1, 0.01], p, (77.9375, 98.375));
    seen("FULL_OPENCV", &[100.0, 100.0, 50.0, 40.0, 0.32, 0.0, 0.0, 0.0, 0.0, 3.2, 0.0, 0.0], p, (63.75, 67.5));
    // A quarter turn off the axis, and more.
    seen("OPENCV_FISHEYE", &[10.0, 10.0, 50.0, 40.0, 0.0, 0.0, 0.0, 0.0], DVec3::X, (50.0 + 10.0 * FRAC_PI_2, 40.0));
    let behind = DVec3::new(0.0, 1.0, -1.0);
    seen("SIMPLE_RADIAL_FISHEYE", &[10.0, 50.0, 40.0, 0.0], behind, (50.0, 40.0 + 15.0 * FRAC_PI_2));
    let t = std::f64::consts::FRAC_PI_4;
    let tilted = DVec3::new(1.0, 0.0, 1.0);
    seen("RADIAL_FISHEYE", &[10.0, 50.0, 40.0, 0.1, 0.01], tilted, {
        (50.0 + 10.0 * (t + 0.1 * t.powi(3) + 0.01 * t.powi(5)), 40.0)
    });
    let prism = [10.0, 10.0, 50.0, 40.0, 0.1, 0.0, 0.01, 0.02, 0.0, 0.0, 0.03, 0.04];
    seen("THIN_PRISM_FISHEYE", &prism, tilted, {
        let (x, y) = (t + 0.1 * t.powi(3) + (0.02 * 3.0 + 0.03) * t * t, (0.01 + 0.04) * t * t);
        (50.0 + 10.0 * x, 40.0 + 10.0 * y)
    });
    let chained = [10.0, 10.0, 50.0, 40.0, 0.1, 0.0, 0.0, 0.0, 0.0, 0.0, 0.02, 0.01, 0.03, 0.001, 0.04, 0.002];
    seen("RAD_TAN_THIN_PRISM_FISHEYE", &chained, tilted, {
        let a = t + 0.1 * t.powi(3);
        let (x, y) = (a + (0.02 * 3.0 + 0.03) * a * a + 0.001 * a.powi(4), (0.01 + 0.04) * a * a + 0.002 * a.powi(4));
        (50.0 + 10.0 * x, 40.0 + 10.0 * y)
    });
    // r = 1: atan(2 tan(0.45)) / 0.9.
    let r = (2.0 * 0.45f64.tan()).atan() / 0.9;
    seen("FOV", &[10.0, 10.0, 50.0, 40.0, 0.9], tilted, (50.0 + 10.0 * r, 40.0));
    seen("FOV", &[10.0, 10.0, 50.0, 40.0, 0.0], tilted, (60.0, 40.0));
}

#[test]
fn what_a_lens_cannot_see_has_no_pixel() {
    for camera in cameras() {
        let fisheye = name(&camera).contains("FISHEYE");
        assert_eq!(camera.project(DVec3::new(1.0, 0.0, -0.1)).is_some(), fisheye, "{}", name(&camera));
        assert_eq!(camera.project(DVec3::NEG_Z), None);
        assert_eq!(camera.project(DVec3::NAN), None, "{}", name(&camera));
    }
}

#[test]
fn where_a_lens_folds_there_is_no_ray() {
    // r (1 - r2) is largest at r = 1 / sqrt 3, where it is 0.385: beyond, nothing; just inside, the nearer of two.
    let camera = Camera::from_colmap("SIMPLE_RADIAL", 200, 200, &[100.0, 100.0, 100.0, -1.0]).unwrap();
    assert_eq!(camera.ray(DVec2::new(139.0, 100.0)), None);
    let ray = camera.ray(DVec2::new(137.5, 100.0)).unwrap();
    assert!(ray.x / ray.z < 1.0 / 3.0f64.sqrt(), "{ray}");
    assert_eq!(camera.project(DVec3::new(0.7, 0.0, 1.0)), None);
    // r (1 - r2 + 0.3 r4) folds, and then grows again: what lies out there is not taken for what is seen.
    let camera = Camera::from_colmap("RADIAL", 200, 200, &[100.0, 100.0, 100.0, -1.0, 0.3]).unwrap();
    for x in 0..100 {
        let pixel = DVec2::new(100.0 + f64::from(x), 100.0);
        if let Some(ray) = camera.ray(pixel) {
            assert!(ray.x / ray.z < 0.75, "{pixel}: {ray}");
            assert!(camera.project(ray).unwrap().distance(pixel) < 1e-9);
        }
    }
}

#[test]
fn derivatives_are_those_of_differences() {
    for camera in cameras() {
        let (Lens::Perspective(lens) | Lens::Equidistant(lens)) = &camera.model.lens else { continue };
        let polynomial = lens.distortion();
        let (q, h) = (DVec2::new(0.31, -0.22), 1e-6);
        let (_, slope) = polynomial.apply(q);
        for (axis, column) in [(DVec2::X, slope.x_axis), (DVec2::Y, slope.y_axis)] {
            let difference = (polynomial.apply(q + axis * h).0 - polynomial.apply(q - axis * h).0) / (2.0 * h);
            assert!(difference.distance(column) < 1e-8, "{}: {difference} {column}", name(&camera));
        }
    }
}

#[test]
fn a_smaller_image_sees_the_same_at_the_same_place() {
    for camera in cameras() {
        let small = camera.down_scaled(4);
        assert_eq!((small.width, small.height), (1000, 750));
        let (a, b) = (camera.ray(DVec2::new(900.0, 700.0)).unwrap(), small.ray(DVec2::new(225.0, 175.0)).unwrap());
        assert!(a.distance(b) < 1e-12, "{}", name(&camera));
        let (_, name, parameters) = small.model.to_colmap();
        assert_eq!(Camera::from_colmap(name, 1000, 750, parameters).unwrap(), small);
        assert_eq!(camera.down_scaled(1), camera);
    }
}

#[test]
fn nonsense_is_refused_in_words() {
    for (name, width, parameters, words) in [
        ("FISHEYE_624", 10, &[1.0; 3][..], "FISHEYE_624 is not known; these are: SIMPLE_PINHOLE"),
        ("PINHOLE", 10, &[1.0; 3], "3 parameters, and PINHOLE has 4"),
        ("PINHOLE", 0, &[1.0; 4], "0 x 10 pixels: 1 to 999999"),
        ("PINHOLE", 1 << 40, &[1.0; 4], "1099511627776 x 10 pixels"),
        ("PINHOLE", 10, &[1.0, 0.0, 1.0, 1.0], "a focal length of 0"),
        ("RADIAL", 10, &[1.0, 1.0, 1.0, f64::NAN, 0.0], "a parameter is NaN"),
        ("FOV", 10, &[1.0, 1.0, 1.0, 1.0, 4.0], "omega is 4"),
    ] {
        let why = Camera::from_colmap(name, width, 10, parameters).unwrap_err();
        assert!(why.contains(words), "{why}");
    }
    assert!(Model::colmap_name(12).is_err() && Model::colmap_name(-1).is_err());
}

#[test]
fn no_finite_parameters_break_a_lens() {
    for k in [1e9, -1e9, 1e300, 1e-300, -50.0, 50.0] {
        for id in 0..12 {
            let (name, count) = Model::colmap_name(id).unwrap();
            let mut parameters = vec![k; count];
            parameters[..2].fill(100.0);
            let Ok(camera) = Camera::from_colmap(name, 200, 100, &parameters) else { continue };
            for pixel in [DVec2::ZERO, DVec2::new(100.0, 50.0), DVec2::new(199.5, 99.5)] {
                if let Some(ray) = camera.ray(pixel) {
                    assert!((ray.length() - 1.0).abs() < 1e-9, "{name} {k}: {ray}");
                }
            }
        }
    }
}
