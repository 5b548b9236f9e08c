//! Truth: round trips over whole frames, derivatives by differences. Garbage: parameters.

use glam::{DVec2, DVec3};

use super::*;

/// A camera and what to call it.
struct Named {
    name: &'static str,
    camera: Camera,
    fisheye: bool,
}

/// Lenses as real calibrations have them, of 4000 x 3000 pixels.
fn cameras() -> Vec<Named> {
    let (flat, wide) = (Projection::Perspective, Projection::Equidistant);
    let radial = |k: [f64; 2]| Distortion::radial(k);
    [
        ("pinhole", [3200.0, 3190.0], Projection::Pinhole),
        ("radial", [2900.0; 2], flat(radial([-0.07, 0.0]))),
        ("radial outward", [2900.0; 2], flat(radial([0.12, 0.0]))),
        ("two radial", [2900.0; 2], flat(radial([-0.12, 0.03]))),
        ("tangential", [2900.0, 2910.0], {
            flat(Distortion { tangential: [8e-4, -5e-4], ..Distortion::radial([-0.28, 0.11]) })
        }),
        ("rational", [2900.0, 2910.0], {
            let (tangential, rational) = ([4e-4, -3e-4], [6.5, 13.0, 3.6]);
            flat(Distortion { tangential, rational, ..Distortion::radial([6.2, 11.0, 0.9]) })
        }),
        ("field of view", [2200.0, 2210.0], Projection::FieldOfView { omega: 0.92 }),
        ("inward radial", [2900.0; 2], Projection::Inward(radial([-0.12, 0.0]))),
        ("division", [2900.0, 2910.0], {
            Projection::Inward(Distortion { rational: [-0.21, 0.0, 0.0], ..Distortion::default() })
        }),
        ("unified", [2000.0, 2010.0], Projection::Unified(Unified { alpha: 0.58, beta: 1.1 })),
        ("near unified", [2000.0, 2010.0], Projection::Unified(Unified { alpha: 0.31, beta: 0.9 })),
        ("fisheye", [1500.0, 1505.0], wide(Distortion::radial([0.03, -0.012, 0.004, -0.0009]))),
        ("radial fisheye", [1500.0; 2], wide(radial([-0.02, 0.003]))),
        ("simple fisheye", [1500.0; 2], wide(radial([-0.02, 0.0]))),
        ("prism fisheye", [1500.0, 1490.0], {
            let (tangential, prism) = ([4e-4, -3e-4], [5e-4, 0.0, -6e-4, 0.0]);
            wide(Distortion { tangential, prism, ..Distortion::radial([0.02, -0.01, 1e-3, -2e-4]) })
        }),
        ("chained fisheye", [1400.0, 1410.0], {
            let (tangential, prism) = ([-5e-4, 4e-4], [9e-4, -1e-4, -7e-4, 2e-4]);
            let radial = Distortion::radial([0.05, -0.03, 0.012, -0.004, 8e-4, -9e-5]);
            wide(Distortion { tangential, prism, chained: true, ..radial })
        }),
    ]
    .into_iter()
    .map(|(name, focal, projection)| {
        let lens = Lens::new(focal.into(), DVec2::new(2010.5, 1488.25), projection).unwrap();
        let camera = Camera::new(4000, 3000, lens).unwrap();
        Named { name, camera, fisheye: matches!(projection, Projection::Equidistant(_) | Projection::Unified(_)) }
    })
    .collect()
}

fn radial(k: [f64; 2]) -> Camera {
    let lens = Lens::new(DVec2::splat(100.0), DVec2::splat(100.0), Projection::Perspective(Distortion::radial(k)));
    Camera::new(200, 200, lens.unwrap()).unwrap()
}

/// Pixel centres of the whole frame, its corners among them.
fn pixels() -> impl Iterator<Item = DVec2> {
    let along = |n: u32, step: usize| (0..n).step_by(step).chain([n - 1]);
    along(3000, 61).flat_map(move |y| along(4000, 61).map(move |x| DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)))
}

#[test]
fn pixels_come_back_from_their_rays_over_the_whole_frame() {
    for Named { name, camera, .. } in cameras() {
        let mut worst = 0.0f64;
        for pixel in pixels() {
            let ray = camera.ray(pixel).unwrap_or_else(|| panic!("{name}: no ray at {pixel}"));
            assert!((ray.length() - 1.0).abs() < 1e-12);
            // Any point of the ray is seen there.
            let back = camera.project(ray * 7.0).unwrap_or_else(|| panic!("{name}: {pixel} is not seen"));
            worst = worst.max(back.distance(pixel));
        }
        assert!(worst < 1e-6, "{name}: {worst} pixels");
    }
}

#[test]
fn rays_come_back_from_their_pixels() {
    for Named { name, camera, .. } in cameras() {
        for (x, y) in [(-0.3, 0.2), (0.1, -0.4), (0.0, 0.0), (1e-12, 0.0)] {
            let ray = DVec3::new(x, y, 1.0).normalize();
            let back = camera.ray(camera.project(ray).unwrap()).unwrap();
            assert!(back.distance(ray) < 1e-10, "{name} {ray}: {back}");
        }
    }
}

#[test]
fn what_a_lens_cannot_see_has_no_pixel() {
    for Named { name, camera, fisheye } in cameras() {
        assert_eq!(camera.project(DVec3::new(1.0, 0.0, -0.1)).is_some(), fisheye, "{name}");
        assert_eq!(camera.project(DVec3::NEG_Z), None);
        assert_eq!(camera.project(DVec3::NAN), None, "{name}");
    }
}

#[test]
fn where_a_lens_folds_there_is_no_ray() {
    // r (1 - r2) is largest at r = 1 / sqrt 3, where it is 0.385: beyond, nothing; just inside, the nearer of two.
    let camera = radial([-1.0, 0.0]);
    assert_eq!(camera.ray(DVec2::new(139.0, 100.0)), None);
    let ray = camera.ray(DVec2::new(137.5, 100.0)).unwrap();
    assert!(ray.x / ray.z < 1.0 / 3.0f64.sqrt(), "{ray}");
    assert_eq!(camera.project(DVec3::new(0.7, 0.0, 1.0)), None);
    // r (1 - r2 + 0.3 r4) folds, and then grows again: what lies out there is not taken for what is seen.
    let camera = radial([-1.0, 0.3]);
    for x in 0..100 {
        let pixel = DVec2::new(100.0 + f64::from(x), 100.0);
        if let Some(ray) = camera.ray(pixel) {
            assert!(ray.x / ray.z < 0.75, "{pixel}: {ray}");
            assert!(camera.project(ray).unwrap().distance(pixel) < 1e-9);
        }
    }
}

#[test]
fn the_division_model_is_that_of_its_formula() {
    // Fitzgibbon 2001: ideal = image / (1 + k r2), r2 of the image.
    let k = -0.25;
    let division = Projection::Inward(Distortion { rational: [k, 0.0, 0.0], ..Distortion::default() });
    let lens = Lens::new(DVec2::splat(100.0), DVec2::splat(100.0), division).unwrap();
    let camera = Camera::new(200, 200, lens).unwrap();
    let ray = camera.ray(DVec2::new(160.0, 180.0)).unwrap();
    let ideal = DVec2::new(0.6, 0.8) / (1.0 + k);
    assert!((ray.truncate() / ray.z).distance(ideal) < 1e-12, "{ray}");
    // At r = 2 stands the pole: what lies beyond is no image.
    assert!(camera.ray(DVec2::new(299.0, 100.0)).is_some());
    assert_eq!(camera.ray(DVec2::new(301.0, 100.0)), None);
}

#[test]
fn derivatives_are_those_of_differences() {
    for Named { name, camera, .. } in cameras() {
        let (Projection::Perspective(distortion)
        | Projection::Equidistant(distortion)
        | Projection::Inward(distortion)) = camera.lens.projection()
        else {
            continue;
        };
        let (q, h) = (DVec2::new(0.31, -0.22), 1e-6);
        let (_, slope) = distortion.apply(q);
        for (axis, column) in [(DVec2::X, slope.x_axis), (DVec2::Y, slope.y_axis)] {
            let difference = (distortion.apply(q + axis * h).0 - distortion.apply(q - axis * h).0) / (2.0 * h);
            assert!(difference.distance(column) < 1e-8, "{name}: {difference} {column}");
        }
    }
}

#[test]
fn a_smaller_image_sees_the_same_at_the_same_place() {
    for Named { name, camera, .. } in cameras() {
        let small = camera.down_scaled(4);
        assert_eq!((small.width, small.height), (1000, 750));
        let (a, b) = (camera.ray(DVec2::new(900.0, 700.0)).unwrap(), small.ray(DVec2::new(225.0, 175.0)).unwrap());
        assert!(a.distance(b) < 1e-12, "{name}");
        let (focal, centre) = (camera.lens.focal() / 4.0, camera.lens.centre() / 4.0);
        let lens = Lens::new(focal, centre, *camera.lens.projection()).unwrap();
        assert_eq!(Camera::new(1000, 750, lens).unwrap(), small);
        assert_eq!(camera.down_scaled(1), camera);
    }
}

#[test]
fn what_is_no_lens_or_no_camera_is_refused_in_words() {
    let lens = |focal: [f64; 2], centre: [f64; 2], projection| Lens::new(focal.into(), centre.into(), projection);
    let omega = |omega| Projection::FieldOfView { omega };
    let unified = |alpha, beta| Projection::Unified(Unified { alpha, beta });
    let prism = Distortion { prism: [0.0, 0.0, 0.0, f64::INFINITY], ..Distortion::default() };
    for (made, words) in [
        (lens([1.0, 0.0], [1.0; 2], Projection::Pinhole), "a focal length is 0; it must be above 0"),
        (lens([-2.0, 1.0], [1.0; 2], Projection::Pinhole), "a focal length is -2"),
        (lens([f64::NAN, 1.0], [1.0; 2], Projection::Pinhole), "a parameter is NaN; it must be finite"),
        (
            lens([1.0; 2], [1.0, 2e9], Projection::Pinhole),
            "a parameter is 2000000000; it must be finite and at most 1e9",
        ),
        (lens([1.0; 2], [1.0; 2], Projection::Equidistant(prism)), "a parameter is inf"),
        (lens([1.0; 2], [1.0; 2], omega(-0.1)), "omega is -0.1; it must be at least 0 and below pi"),
        (lens([1.0; 2], [1.0; 2], omega(f64::NAN)), "a parameter is NaN"),
        (lens([1.0; 2], [1.0; 2], unified(1.1, 1.0)), "alpha is 1.1; it must be 0 to 1"),
        (lens([1.0; 2], [1.0; 2], unified(0.5, 0.0)), "beta is 0; it must be above 0"),
        (lens([1.0; 2], [1.0; 2], unified(0.5, f64::NAN)), "a parameter is NaN"),
    ] {
        let why = made.unwrap_err();
        assert!(why.contains(words), "{why}");
    }
    let pinhole = Lens::pinhole(DVec2::ONE, DVec2::ONE);
    for (width, height) in [(0, 10), (10, 0), (1_000_000, 10), (10, 1 << 40)] {
        let why = Camera::new(width, height, pinhole.clone()).unwrap_err();
        assert!(why.contains(&format!("{width} x {height} pixels; 1 to 999999 a side")), "{why}");
    }
    assert!(Camera::new(999_999, 1, pinhole).is_ok());
}
