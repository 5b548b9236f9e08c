use std::sync::Arc;

use glam::{DVec2, DVec3, Vec3};

use super::*;
use crate::base::convert::to_u32;
use crate::scene::camera::{Camera, Lens};
use crate::scene::frame::Frame;
use crate::scene::light::Sun;
use crate::scene::pose::Pose;
use crate::scene::{Material, Mesh, brdf};
use crate::trace::{Bvh, sky_visibility};

const WHITE: Material = Material { kd: [1.0; 3], ks: [0.0; 3], r: 0.5 };

/// Squares, each of two triangles, given by a corner and two edges.
fn mesh(squares: &[[DVec3; 3]]) -> Mesh {
    let vertices: Vec<DVec3> = squares.iter().flat_map(|[o, a, b]| [*o, *o + a, *o + a + b, *o + b]).collect();
    let triangles = (0..to_u32(squares.len())).flat_map(|k| [[0, 1, 2], [0, 2, 3]].map(|t| t.map(|i| 4 * k + i)));
    Mesh::new(&vertices, triangles.collect()).unwrap()
}

fn floor() -> [DVec3; 3] {
    [DVec3::new(-10.0, -10.0, 0.0), DVec3::X * 20.0, DVec3::Y * 20.0]
}

/// Looks at the middle of the floor; the image shows floor alone.
fn frame(eye: DVec3) -> Frame {
    let lens = Lens::pinhole(DVec2::splat(100.0), DVec2::new(20.0, 15.0));
    let camera = Arc::new(Camera { width: 40, height: 30, lens });
    Frame { name: "f.jpg".into(), camera, pose: Pose::look_at(eye, DVec3::ZERO, DVec3::Y) }
}

fn noon() -> Lighting {
    Lighting::new(Sun { direction: Vec3::Z, color: Vec3::ONE }, Vec3::ZERO)
}

fn every_pixel(image: &relight::Rendering, value: [f32; 3]) {
    for p in &image.rgb {
        assert!(p.iter().zip(value).all(|(a, b)| (a - b).abs() < 2e-6), "{p:?} against {value:?}");
    }
}

#[test]
fn a_white_lambertian_that_faces_the_sun_has_radiance_one() {
    let (mesh, frame) = (mesh(&[floor()]), frame(DVec3::new(2.0, -3.0, 8.0)));
    let bvh = Bvh::build(&mesh);
    every_pixel(&relight(&mesh, &bvh, &[WHITE; 2], &frame, &noon()).unwrap(), [1.0; 3]);
    // A sun at 60 degrees from the normal gives half; the sky adds its own radiance.
    let sun = Sun { direction: Vec3::new(0.0, 0.75_f32.sqrt(), 0.5), color: Vec3::ONE };
    let lighting = Lighting::new(sun, Vec3::new(0.1, 0.2, 0.3));
    every_pixel(&relight(&mesh, &bvh, &[WHITE; 2], &frame, &lighting).unwrap(), [0.6, 0.7, 0.8]);
}

#[test]
fn in_shadow_the_sky_is_all() {
    // A roof above the camera covers the whole floor.
    let roof = [DVec3::new(-15.0, -15.0, 20.0), DVec3::X * 30.0, DVec3::Y * 30.0];
    let (mesh, frame) = (mesh(&[floor(), roof]), frame(DVec3::new(2.0, -3.0, 8.0)));
    let lighting = Lighting { sky: Vec3::new(0.1, 0.2, 0.3), ..noon() };
    let grey = Material { kd: [0.5; 3], ..WHITE };
    every_pixel(&relight(&mesh, &Bvh::build(&mesh), &[grey; 4], &frame, &lighting).unwrap(), [0.05, 0.1, 0.15]);
}

#[test]
fn the_specular_part_is_that_of_the_model() {
    let (mesh, m) = (mesh(&[floor()]), Material { kd: [0.2; 3], ks: [1.0, 0.5, 0.0], r: 0.4 });
    let frame = frame(DVec3::new(0.0, -6.0, 8.0));
    let lighting = Lighting { sun: Sun { direction: Vec3::new(0.0, 0.6, 0.8), color: Vec3::ONE }, ..noon() };
    let image = relight(&mesh, &Bvh::build(&mesh), &[m; 2], &frame, &lighting).unwrap();
    // The middle of the image looks along the mirrored sun.
    for (x, y) in [(20, 15), (17, 11), (3, 28)] {
        let ray = frame.camera.ray(DVec2::new(f64::from(x) + 0.5, f64::from(y) + 0.5)).unwrap();
        let wo = -frame.pose.to_world(ray).as_vec3();
        let truth = brdf::radiance(&m, lighting.sun.direction, wo);
        let found = Vec3::from(image.rgb[y as usize * 40 + x as usize]);
        assert!((found - truth).abs().max_element() < 1e-4, "{x} {y}: {found} against {truth}");
        assert!(x == 3 || truth.x > 0.5, "no highlight at {x} {y}: {truth}");
    }
}

#[test]
fn a_triangle_is_seen_from_behind_as_from_before() {
    let turned = [DVec3::new(-10.0, -10.0, 0.0), DVec3::Y * 20.0, DVec3::X * 20.0];
    let (mesh, frame) = (mesh(&[turned]), frame(DVec3::new(2.0, -3.0, 8.0)));
    every_pixel(&relight(&mesh, &Bvh::build(&mesh), &[WHITE; 2], &frame, &noon()).unwrap(), [1.0; 3]);
}

#[test]
fn what_leaves_the_mesh_sees_the_background() {
    let small = [DVec3::new(-0.5, -0.5, 0.0), DVec3::X, DVec3::Y];
    let (mesh, frame) = (mesh(&[small]), frame(DVec3::Z * 8.0));
    let lighting = Lighting { background: Vec3::splat(0.25), ..noon() };
    let image = relight(&mesh, &Bvh::build(&mesh), &[WHITE; 2], &frame, &lighting).unwrap();
    assert_eq!((image.rgb[0], image.rgb[15 * 40 + 20]), ([0.25; 3], [1.0; 3]));
    // The square is 12.5 pixels wide.
    let seen = image.rgb.iter().filter(|p| p[0] > 0.5).count();
    assert!((144..=169).contains(&seen), "{seen}");
}

#[test]
fn the_sky_is_seen_as_far_as_nothing_stands_before_it() {
    // A wall that stands alone sees half the sky.
    let wall = |high: f64| [DVec3::new(-500.0, 0.0, 0.0), DVec3::X * 1000.0, DVec3::Z * high];
    let share = |squares: &[[DVec3; 3]]| {
        let mesh = mesh(squares);
        sky_visibility(&mesh, &Bvh::build(&mesh), Vec3::Z, 1024, 0..mesh.len())
    };
    assert!((share(&[wall(1.0)])[0] - 0.5).abs() < 0.01);
    assert_eq!(share(&[floor()]), [1.0, 1.0]);
    let strip = [DVec3::new(-0.5, -0.2, 0.0), DVec3::X, DVec3::Y * 0.1];
    // The wall's top is so high, and its ends so far, that it takes the half of the sky behind it.
    assert!((share(&[strip, wall(1000.0)])[0] - 0.5).abs() < 0.02);
}

#[test]
fn lists_of_another_length_are_refused() {
    let (mesh, frame) = (mesh(&[floor()]), frame(DVec3::Z * 8.0));
    let bvh = Bvh::build(&mesh);
    let words = relight(&mesh, &bvh, &[WHITE], &frame, &noon()).unwrap_err().to_string();
    assert!(words.contains("1 materials for 2 triangles"), "{words}");
    let lighting = Lighting { visibility: vec![1.0; 5].into(), ..noon() };
    let words = relight(&mesh, &bvh, &[WHITE; 2], &frame, &lighting).unwrap_err().to_string();
    assert!(words.contains("5 shares of the sky for 2 triangles"), "{words}");
}

#[test]
fn shrinking_averages() {
    let rgb = (0..16).map(|i| [i as f32; 3]).collect();
    let image = relight::Rendering { width: 4, height: 4, rgb }.shrink(2);
    assert_eq!((image.width, image.height), (2, 2));
    assert_eq!(image.rgb, [[2.5; 3], [4.5; 3], [10.5; 3], [12.5; 3]]);
}

#[test]
fn threads_do_not_change_a_picture() {
    let tilted = [DVec3::new(-3.0, -3.0, 1.0), DVec3::new(4.0, 0.5, 1.0), DVec3::new(-0.5, 4.0, 0.3)];
    let (mesh, frame) = (mesh(&[floor(), tilted]), frame(DVec3::new(2.0, -3.0, 8.0)));
    let bvh = Bvh::build(&mesh);
    let draw = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().unwrap();
        pool.install(|| {
            let visibility = sky_visibility(&mesh, &bvh, Vec3::Z, 16, 0..mesh.len()).into();
            relight(&mesh, &bvh, &[WHITE; 4], &frame, &Lighting { visibility, sky: Vec3::ONE, ..noon() }).unwrap()
        })
    };
    assert_eq!(draw(1), draw(3));
}
