//! The sun and the sky of a town are found, and none where there is none.

use glam::Vec3;

use super::town::{Light, seen, town};
use crate::base::Array;
use crate::flow::pool;
use crate::light::directions::{angle, turned};
use crate::light::{Clues, Decision, Found, Gains, Scene, Settings, find, sample};
use crate::scene::Mesh;
use crate::trace::Bvh;

fn found(mesh: &Mesh, light: &Light, threads: usize) -> Found {
    let bvh = Bvh::build(mesh);
    let sample = sample(mesh, Vec3::Z, &[], 1500);
    let seen = seen(mesh, &bvh, &sample, light);
    let scene = Scene { mesh, bvh: &bvh, up: Vec3::Z };
    let settings = Settings { white: Some(f64::from(light.color.max(0.2))) };
    pool::share(threads, || find(&scene, &sample, &seen, &Gains::none(5), &settings)).unwrap()
}

fn afternoon() -> Light {
    Light { sun: Vec3::new(0.5, -0.6, 0.6).normalize(), color: 0.9, sky: [0.18, 0.22, 0.3], bounce: 0.0, cap: 0.0 }
}

fn sun(found: &Found) -> Vec3 {
    glam::DVec3::from(found.sun.expect("there is a sun")).as_vec3()
}

#[test]
fn the_sun_is_found_to_a_degree_and_the_ratio_to_a_twentieth() {
    let light = afternoon();
    let found = found(&town(8, 3), &light, 2);
    assert_eq!(found.decided, Decision::Sun);
    assert!(angle(sun(&found), light.sun) < 1.0, "{} degrees off", angle(sun(&found), light.sun));
    for c in 0..3 {
        let off = found.sky[c] / found.color[c] / (light.sky[c] / light.color) - 1.0;
        assert!(off.abs() < 0.05, "channel {c}: the ratio is off by {off}");
    }
    assert_eq!(found.bounce, [0.0; 3]);
    assert!(found.spread.sun_degrees < 2.0 && found.spread.ratio.iter().all(|s| *s < 0.1), "{:?}", found.spread);
}

#[test]
fn light_from_surface_to_surface_is_told_from_none() {
    // About what the town's surfaces send.
    let light = Light { bounce: 0.12, ..afternoon() };
    let found = found(&town(8, 3), &light, 2);
    assert!(found.bounce.iter().all(|b| (0.09..0.15).contains(b)), "{:?}", found.bounce);
    assert!(angle(sun(&found), light.sun) < 1.0, "{} degrees off", angle(sun(&found), light.sun));
    for c in 0..3 {
        let off = found.sky[c] / found.color[c] / (light.sky[c] / light.color) - 1.0;
        assert!(off.abs() < 0.2, "channel {c}: the ratio is off by {off}");
    }
}

#[test]
fn a_sky_alone_is_no_sun() {
    let found = found(&town(8, 3), &Light { color: 0.0, sky: [0.6; 3], ..afternoon() }, 2);
    assert_eq!((found.sun, found.decided), (None, Decision::NoSun), "turned {}", found.turned);
    assert!(found.turned < 0.1, "{}", found.turned);
}

#[test]
fn a_bright_cloud_is_no_sun() {
    let found = found(&town(8, 3), &Light { cap: 35.0, ..afternoon() }, 2);
    assert_eq!((found.sun, found.decided), (None, Decision::NoSun), "{} {}", found.turned_sure, found.soft_sure);
}

#[test]
fn a_known_sun_gets_its_ratio_and_the_right_hour_costs_least() {
    let (mesh, light) = (town(8, 3), afternoon());
    let bvh = Bvh::build(&mesh);
    let sample = sample(&mesh, Vec3::Z, &[], 1500);
    let scene = Scene { mesh: &mesh, bvh: &bvh, up: Vec3::Z };
    let clues = Clues::new(&scene, &sample, &seen(&mesh, &bvh, &sample, &light), &Gains::none(5));
    let settings = Settings { white: Some(0.9) };
    let told = clues.under(light.sun, &settings);
    assert_eq!(told.decided, Decision::Sun);
    assert!(angle(sun(&told), light.sun) < 0.01, "the sun that was given");
    assert!((told.sky[1] / told.color[1] / (0.22 / 0.9) - 1.0).abs() < 0.05, "{:?}", told.sky);
    assert_eq!(clues.under(turned(light.sun, Vec3::Z, 60.0), &settings).decided, Decision::Doubtful);
    let hours: Vec<Vec3> = (-3..=3).map(|hour| turned(light.sun, Vec3::Z, 15.0 * hour as f32)).collect();
    let costs = clues.costs(&hours, &settings);
    assert!((0..7).all(|hour| hour == 3 || costs[hour] > costs[3]), "{costs:?}");
}

#[test]
fn a_flat_field_tells_no_sun() {
    let town = town(8, 3);
    let flat: Vec<Vec3> = town.positions.iter().map(|p| Vec3::new(p.x, p.y, 0.0)).collect();
    let field = Mesh { positions: Array::from(flat), ..town };
    let found = found(&field, &afternoon(), 2);
    assert!(matches!(found.decided, Decision::NoSun | Decision::TooLittle), "{:?} {}", found.decided, found.turned);
}

#[test]
fn answers_depend_neither_on_threads_nor_on_the_size_of_the_scene() {
    let small = town(5, 2);
    let one = found(&small, &afternoon(), 1);
    assert_eq!(found(&small, &afternoon(), 3), one);
    let larger: Vec<Vec3> = small.positions.iter().map(|p| *p * 1024.0).collect();
    let larger = Mesh { positions: Array::from(larger), ..small };
    let other = found(&larger, &afternoon(), 2);
    assert!(angle(sun(&other), sun(&one)) < 0.6, "{} degrees apart", angle(sun(&other), sun(&one)));
}

#[test]
fn nothing_seen_is_too_little() {
    let mesh = town(2, 1);
    let bvh = Bvh::build(&mesh);
    let scene = Scene { mesh: &mesh, bvh: &bvh, up: Vec3::Z };
    let found = find(&scene, &sample(&mesh, Vec3::Z, &[], 10), &[], &Gains::none(1), &Settings::default());
    assert_eq!((found.sun, found.decided), (None, Decision::TooLittle));
}
