//! A sample covers normals and place, and is the same each time.

use glam::{DVec3, Vec3};

use super::town::town;
use crate::base::ids::TriangleId;
use crate::light::sample;
use crate::scene::Mesh;

#[test]
fn a_sample_holds_walls_and_ground_and_is_ascending() {
    let mesh = town(12, 4);
    let taken = sample(&mesh, Vec3::Z, &[], 1000);
    assert!((900..1100).contains(&taken.len()), "{}", taken.len());
    assert!(taken.windows(2).all(|two| two[0] < two[1]));
    let area = |t: &TriangleId| {
        let [a, b, c] = mesh.corners(*t);
        (b - a).cross(c - a).length()
    };
    let ground = |t: &TriangleId| mesh.normal(*t).is_some_and(|normal| normal.z > 0.99);
    let all = TriangleId::all(mesh.len()).map(|t| area(&t)).sum::<f32>();
    let of_area = TriangleId::all(mesh.len()).filter(ground).map(|t| area(&t)).sum::<f32>() / all;
    let of_sample = taken.iter().filter(|t| ground(t)).count() as f32 / taken.len() as f32;
    assert!(of_sample > 0.1 && of_sample < 0.7 * of_area, "{of_sample} of the sample, {of_area} of the area is ground");
    assert_eq!(sample(&mesh, Vec3::Z, &[], 1000), taken);
}

#[test]
fn what_is_hardly_seen_is_passed_over_and_a_small_mesh_is_taken_whole() {
    let mesh = town(3, 2);
    let seen: Vec<f32> = (0..mesh.len()).map(|t| if t % 2 == 0 { 30.0 } else { 11.0 }).collect();
    let taken = sample(&mesh, Vec3::Z, &seen, 1_000_000);
    assert_eq!(taken.len(), mesh.len().div_ceil(2));
    assert!(taken.iter().all(|t| t.index() % 2 == 0));
    assert!(sample(&mesh, Vec3::Z, &vec![0.0; mesh.len()], 100).is_empty());
    let flat = Mesh::new(&[DVec3::ZERO, DVec3::X, DVec3::X * 2.0], vec![[0, 1, 2]]).unwrap();
    assert!(sample(&flat, Vec3::Z, &[], 100).is_empty(), "a triangle without area");
}
