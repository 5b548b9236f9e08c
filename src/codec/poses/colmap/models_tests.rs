//! Truth: points by hand in every model, and models that are written as they were read. Garbage: parameters.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4};

use glam::{DVec2, DVec3};

use super::models::{by_id, by_name, written};
use crate::scene::camera::Camera;

fn camera(name: &str, width: u64, height: u64, parameters: &[f64]) -> Result<Camera, String> {
    let made = by_name(name)?.camera(width, height, parameters)?;
    made.ok_or_else(|| "a panorama".to_owned())
}

#[test]
fn single_points_by_hand() {
    let seen = |name: &str, parameters: &[f64], point: DVec3, pixel: (f64, f64)| {
        let found = camera(name, 100, 100, parameters).unwrap().project(point).unwrap();
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
    let t = FRAC_PI_4;
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
    seen("SIMPLE_FISHEYE", &[10.0, 50.0, 40.0], tilted, (50.0 + 10.0 * t, 40.0));
    seen("FISHEYE", &[10.0, 20.0, 50.0, 40.0], DVec3::new(0.0, 1.0, 1.0), (50.0, 40.0 + 20.0 * t));
    // 0.5 / (1 - 0.8 / 4) = 0.625.
    seen("SIMPLE_DIVISION", &[100.0, 50.0, 40.0, -0.8], DVec3::new(0.625, 0.0, 1.0), (100.0, 40.0));
    seen("DIVISION", &[100.0, 200.0, 50.0, 40.0, -0.8], DVec3::new(0.0, 0.625, 1.0), (50.0, 140.0));
    // d = sqrt(2 + 1): 1 / (0.6 sqrt 3 + 0.4).
    let unified = 10.0 / (0.6 * 3.0f64.sqrt() + 0.4);
    seen("EUCM", &[10.0, 10.0, 50.0, 40.0, 0.6, 2.0], tilted, (50.0 + unified, 40.0));
}

#[test]
fn a_lens_is_written_as_it_was_read_to_the_bit() {
    let two = |k: &[f64]| [&[2900.1, 2910.7, 2010.3, 1488.9], k].concat();
    let one = |k: &[f64]| [&[2900.1, 2010.3, 1488.9], k].concat();
    let k = [-0.28, 0.11, 8e-4, -5e-4, 0.012, -0.004, 9e-4, 1.0 / 3.0, 7e-5, -6e-5, 5e-5, -4e-5];
    let all = [
        ("PINHOLE", two(&[])),
        ("SIMPLE_RADIAL", one(&k[..1])),
        ("SIMPLE_RADIAL", one(&[0.0])),
        ("RADIAL", one(&k[..2])),
        ("OPENCV", two(&k[..4])),
        ("OPENCV_FISHEYE", two(&k[..4])),
        ("FULL_OPENCV", two(&k[..8])),
        ("FOV", two(&[0.92])),
        ("SIMPLE_RADIAL_FISHEYE", one(&k[..1])),
        ("RADIAL_FISHEYE", one(&k[..2])),
        ("THIN_PRISM_FISHEYE", two(&k[..8])),
        ("RAD_TAN_THIN_PRISM_FISHEYE", two(&k)),
        ("DIVISION", two(&k[..1])),
        ("EUCM", two(&[0.6, 1.1])),
    ];
    for (name, parameters) in all {
        let read = camera(name, 4000, 3000, &parameters).unwrap();
        for (camera, scale) in [(read.clone(), 1), (read.down_scaled(4), 4)] {
            let written = written(&camera.lens).unwrap();
            assert_eq!((by_id(written.id).unwrap().name, written.name), (name, name));
            assert!(scale > 1 || written.parameters == parameters, "{written:?}");
            let (width, height) = (camera.width.into(), camera.height.into());
            assert_eq!(self::camera(name, width, height, &written.parameters).unwrap(), camera, "{name}");
        }
    }
}

#[test]
fn a_lens_is_written_in_the_model_with_the_fewest_terms() {
    for (name, parameters, shorter) in [
        ("SIMPLE_PINHOLE", &[9.0, 5.0, 4.0][..], "PINHOLE"),
        ("RADIAL", &[9.0, 5.0, 4.0, 0.1, 0.0], "SIMPLE_RADIAL"),
        ("OPENCV", &[9.0, 9.0, 5.0, 4.0, 0.1, 0.2, 0.0, 0.0], "RADIAL"),
        ("OPENCV", &[9.0, 9.5, 5.0, 4.0, 0.1, 0.2, 0.0, 0.0], "OPENCV"),
        ("FULL_OPENCV", &[9.0, 9.0, 5.0, 4.0, 0.1, 0.2, 0.0, 0.3, 0.0, 0.0, 0.0, 0.0], "OPENCV"),
        ("OPENCV_FISHEYE", &[9.0, 9.0, 5.0, 4.0, 0.0, 0.0, 0.0, 0.0], "SIMPLE_RADIAL_FISHEYE"),
        ("FISHEYE", &[9.0, 9.5, 5.0, 4.0], "OPENCV_FISHEYE"),
        ("SIMPLE_DIVISION", &[9.0, 5.0, 4.0, 0.1], "DIVISION"),
    ] {
        let camera = camera(name, 10, 8, parameters).unwrap();
        let written = written(&camera.lens).unwrap();
        assert_eq!(written.name, shorter, "{name}");
        assert_eq!(self::camera(shorter, 10, 8, &written.parameters).unwrap(), camera, "{name}");
    }
}

#[test]
fn nonsense_is_refused_in_words() {
    for (name, width, parameters, words) in [
        ("FISHEYE_624", 10, &[1.0; 3][..], "FISHEYE_624 is not known; these are: SIMPLE_PINHOLE"),
        ("PINHOLE", 10, &[1.0; 3], "3 parameters are given, and PINHOLE has 4"),
        ("PINHOLE", 0, &[1.0; 4], "0 x 10 pixels; 1 to 999999"),
        ("PINHOLE", 1 << 40, &[1.0; 4], "1099511627776 x 10 pixels"),
        ("PINHOLE", 10, &[1.0, 0.0, 1.0, 1.0], "a focal length is 0"),
        ("RADIAL", 10, &[1.0, 1.0, 1.0, f64::NAN, 0.0], "a parameter is NaN"),
        ("FOV", 10, &[1.0, 1.0, 1.0, 1.0, 4.0], "omega is 4"),
    ] {
        let why = camera(name, width, 10, parameters).unwrap_err();
        assert!(why.contains(words), "{why}");
    }
    assert!(by_id(18).is_err() && by_id(-1).is_err());
}

#[test]
fn no_finite_parameters_break_a_lens() {
    for k in [1e9, -1e9, 1e300, 1e-300, -50.0, 50.0] {
        for id in 0..17 {
            let model = by_id(id).unwrap();
            let mut parameters = vec![k; model.count()];
            parameters[..2].fill(100.0);
            let Ok(Some(camera)) = model.camera(200, 100, &parameters) else { continue };
            for pixel in [DVec2::ZERO, DVec2::new(100.0, 50.0), DVec2::new(199.5, 99.5)] {
                if let Some(ray) = camera.ray(pixel) {
                    assert!((ray.length() - 1.0).abs() < 1e-9, "{} {k}: {ray}", model.name);
                }
            }
        }
    }
}
