//! Towns by their triangles, and by the files that are made of them.

mod folder;
mod worlds;

use std::collections::BTreeMap;

use glam::{DVec2, DVec3};

use super::surface::{Block, Part, Spot};
use super::town::Use;
use super::*;
use crate::scene::Material;

/// The mesh of a city and the material of each of its triangles.
#[derive(Debug, Clone)]
struct City {
    mesh: Mesh,
    materials: Vec<Material>,
}

fn build(config: &CityConfig) -> Result<City> {
    let mut materials = Vec::new();
    let mesh = fill(config, Version::Given, survey(config, Version::Given)?, &mut |block| {
        materials.extend_from_slice(&block.materials);
        Ok(())
    })?;
    Ok(City { mesh, materials })
}

fn small(seed: u64) -> CityConfig {
    CityConfig { seed, triangles: 5000, frames: 3, width: 64, height: 48, ..CityConfig::default() }
}

#[test]
fn every_triangle_has_area_and_a_material_within_range() {
    for config in [small(1), small(2), CityConfig::default()] {
        let city = build(&config).unwrap();
        assert_eq!(city.materials.len(), city.mesh.len());
        assert_eq!(city.mesh.degenerate(), 0);
        for (t, m) in city.materials.iter().enumerate() {
            assert!(m.to_array().iter().all(|v| (0.0..=1.0).contains(v)), "triangle {t}: {m:?}");
            assert!(m.kd.iter().all(|v| (0.01..=0.8).contains(v)), "triangle {t}: {m:?}");
        }
    }
}

#[test]
fn the_count_is_about_what_was_asked_for() {
    for (triangles, slack) in [(6_000, 0.5), (20_000, 0.25), (50_000, 0.2), (150_000, 0.2)] {
        for seed in 1..4 {
            let found = build(&CityConfig { triangles, seed, ..CityConfig::default() }).unwrap().mesh.len();
            let ratio = found as f64 / f64::from(triangles);
            assert!((1.0 - slack..1.0 + slack).contains(&ratio), "{found} triangles for {triangles}, seed {seed}");
        }
    }
}

#[test]
fn a_seed_is_a_city() {
    let (a, b, c) = (build(&small(7)).unwrap(), build(&small(7)).unwrap(), build(&small(8)).unwrap());
    assert_eq!((&a.mesh, &a.materials), (&b.mesh, &b.materials));
    assert_ne!(a.materials, c.materials);
}

#[test]
fn shapes_are_turned_outside_out() {
    // Of closed shapes, and of one that is open below only, the volume is positive if triangles face outwards.
    let spot = Spot::new(DVec2::splat(20.0), 0.7);
    let finish = palette::marking();
    let volume = |make: &dyn Fn(&mut Block)| {
        let town = Town { seed: 1, side: 1 };
        let mut block = Block {
            surface: Surface::default(),
            rng: town.rng(9, [0, 0]),
            ground: town.ground([0, 0]),
            cell: 0.9,
            world: World::Plain,
            part: Part::Both,
        };
        make(&mut block);
        let Surface { vertices, triangles, .. } = block.surface;
        let low = vertices.iter().map(|v| v.z).fold(f64::INFINITY, f64::min);
        let at = |i: u32| vertices[i as usize] - DVec3::new(0.0, 0.0, low);
        triangles.iter().map(|t| at(t[0]).dot(at(t[1]).cross(at(t[2]))) / 6.0).sum::<f64>()
    };
    let near = |found: f64, truth: f64| assert!((found / truth - 1.0).abs() < 0.25, "{found} against {truth}");
    near(volume(&|b| b.solid(spot, DVec3::ZERO, DVec3::new(2.0, 3.0, 4.0), &finish, &finish)), 24.0);
    near(volume(&|b| b.blob(spot, DVec3::Z * 5.0, DVec3::splat(2.0), 0.0, &finish)), 30.0);
    let cone = [DVec2::new(2.0, 0.0), DVec2::new(1.0, 2.0), DVec2::new(0.0, 4.0)];
    near(volume(&|b| b.lathe(spot, &cone, 16, 0.0, &finish)), 16.7);
}

#[test]
fn blocks_meet_without_a_gap() {
    // Every corner of the ground that two blocks share is the same point, bit for bit.
    let town = Town { seed: 3, side: 2 };
    let end = town::PITCH;
    let mut seen: BTreeMap<[i32; 2], DVec3> = BTreeMap::new();
    for at in town.blocks() {
        for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
            let place = town.ground(at).point(DVec2::new(f64::from(dx) * end, f64::from(dy) * end));
            let first = *seen.entry([at[0] + dx, at[1] + dy]).or_insert(place);
            assert!(first.distance(place) < 1e-9, "{first} {place}");
        }
    }
}

#[test]
fn a_hand_of_blocks_has_every_use() {
    let town = Town { seed: 5, side: 4 };
    let uses: Vec<town::Use> = town.blocks().into_iter().map(|at| town.land_use(at)).collect();
    for u in [Use::Houses, Use::Flats, Use::Hall, Use::Park, Use::Church, Use::Field] {
        assert!(uses.contains(&u), "{u:?}");
    }
}

#[test]
fn values_out_of_range_are_named_together() {
    let config = CityConfig {
        triangles: 3,
        sun_elevation_deg: f64::NAN,
        frames: 0,
        suns: vec![[40.0, 0.0]],
        ..CityConfig::default()
    };
    let words = build(&config).unwrap_err().to_string();
    for name in [
        "triangles is 3",
        "sun_elevation_deg is NaN",
        "frames is 0",
        "5000 to 20000000",
        "suns is [[40.0, 0.0]], but must be none, or 2 to 16 of",
    ] {
        assert!(words.contains(name), "{words}");
    }
}
