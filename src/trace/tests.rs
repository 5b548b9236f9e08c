use glam::{DVec3, UVec2, Vec3};
use rand::{RngExt, SeedableRng};
use rand_pcg::Pcg64Mcg;

use super::bvh::{Best, DEPTH};
use super::ray::Course;
use super::slab::EMPTY;
use super::triangle::intersect;
use super::{Bvh, Hit, Ray, tile};
use crate::base::convert::{to_f32, to_u32};
use crate::base::ids::TriangleId;
use crate::scene::Mesh;

fn mesh(positions: Vec<Vec3>, triangles: Vec<[u32; 3]>) -> Mesh {
    Mesh { origin: DVec3::ZERO, positions: positions.into(), triangles: triangles.into() }
}

/// Triangles of their own corners.
fn soup(corners: Vec<Vec3>) -> Mesh {
    let n = to_u32(corners.len()) / 3;
    mesh(corners, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect())
}

fn vector(rng: &mut Pcg64Mcg) -> Vec3 {
    Vec3::from_array(std::array::from_fn(|_| rng.random_range(-1.0f32..1.0)))
}

/// What a loop over all triangles finds.
fn brute(bvh: &Bvh, ray: &Ray, t_max: f32) -> Option<Hit> {
    let (origin, course) = (bvh.scaled(ray.origin)?, Course::new(ray.direction)?);
    let unit = course.unit / bvh.scale;
    let mut best = Best { t: to_f32(f64::from(t_max) / unit), ..Best::NONE };
    for packed in bvh.triangles.iter() {
        if let Some(meeting) = intersect(packed, &origin, &course) {
            best.offer(packed.id, meeting);
        }
    }
    best.is_some().then(|| best.hit(unit))
}

fn bits(hit: Option<Hit>) -> Option<[u32; 4]> {
    hit.map(|h| [h.triangle.0, h.t.to_bits(), h.u.to_bits(), h.v.to_bits()])
}

/// Every way of casting agrees with the loop, to the bit. Returns the number of hits.
fn agree(bvh: &Bvh, origin: Vec3, directions: &[Vec3]) -> usize {
    let mut hits = vec![Hit::MISS; directions.len()];
    tile::cast(bvh, origin, directions, &mut hits);
    for (&direction, &hit) in directions.iter().zip(&hits) {
        let ray = Ray { origin, direction };
        let truth = brute(bvh, &ray, f32::INFINITY);
        assert_eq!(bits(bvh.nearest(&ray, f32::INFINITY)), bits(truth), "nearest {ray:?}");
        assert_eq!(bits(hit.is_some().then_some(hit)), bits(truth), "tile {ray:?}");
        assert_eq!(bvh.occluded(&ray, f32::INFINITY), truth.is_some(), "occluded {ray:?}");
        if let Some(h) = truth {
            for t_max in [h.t, h.t.next_down(), h.t * 1.5] {
                let limited = brute(bvh, &ray, t_max);
                assert_eq!(bits(bvh.nearest(&ray, t_max)), bits(limited), "nearest {ray:?} up to {t_max:e}");
                assert_eq!(bvh.occluded(&ray, t_max), limited.is_some(), "occluded {ray:?} up to {t_max:e}");
            }
        }
    }
    hits.iter().filter(|h| h.is_some()).count()
}

/// Directions as a camera has them: neighbours, about one axis.
fn fan(rng: &mut Pcg64Mcg, n: usize) -> Vec<Vec3> {
    let axis = vector(rng);
    (0..n).map(|_| axis + 0.2 * vector(rng)).collect()
}

fn icosphere(levels: usize, centre: Vec3) -> Mesh {
    let g = (1.0 + 5f32.sqrt()) / 2.0;
    let mut points: Vec<Vec3> = Vec::new();
    for (a, b) in [(-1.0, g), (1.0, g), (-1.0, -g), (1.0, -g)] {
        points.extend([Vec3::new(a, b, 0.0), Vec3::new(0.0, a, b), Vec3::new(b, 0.0, a)]);
    }
    points.iter_mut().for_each(|p| *p = p.normalize());
    // Faces: every three of the twelve that are all neighbours, turned outward.
    let near = |i: usize, j: usize| points[i].dot(points[j]) > 0.4;
    let mut faces = Vec::new();
    for i in 0..12 {
        for j in i + 1..12 {
            for k in j + 1..12 {
                if near(i, j) && near(j, k) && near(i, k) {
                    let out = (points[j] - points[i]).cross(points[k] - points[i]).dot(points[i]) > 0.0;
                    faces.push(if out { [i, j, k] } else { [i, k, j] }.map(to_u32));
                }
            }
        }
    }
    assert_eq!(faces.len(), 20);
    for _ in 0..levels {
        let mut middle = std::collections::BTreeMap::new();
        let mut halve = |a: u32, b: u32, points: &mut Vec<Vec3>| {
            *middle.entry((a.min(b), a.max(b))).or_insert_with(|| {
                points.push((points[a as usize] + points[b as usize]).normalize());
                to_u32(points.len()) - 1
            })
        };
        faces = faces
            .iter()
            .flat_map(|&[a, b, c]| {
                let (ab, bc, ca) = (halve(a, b, &mut points), halve(b, c, &mut points), halve(c, a, &mut points));
                [[a, ab, ca], [b, bc, ab], [c, ca, bc], [ab, bc, ca]]
            })
            .collect();
    }
    mesh(points.into_iter().map(|p| p + centre).collect(), faces)
}

/// A box of 12 triangles, its corners at `low` and `high`.
fn cuboid(low: Vec3, high: Vec3) -> Mesh {
    let corner = |i: usize| Vec3::select(glam::BVec3::new(i & 1 > 0, i & 2 > 0, i & 4 > 0), high, low);
    let quads = [[0, 4, 6, 2], [1, 3, 7, 5], [0, 1, 5, 4], [2, 6, 7, 3], [0, 2, 3, 1], [4, 5, 7, 6]];
    let triangles = quads.iter().flat_map(|&[a, b, c, d]| [[a, b, c], [a, c, d]]).collect();
    mesh((0..8).map(corner).collect(), triangles)
}

#[test]
fn random_scenes_agree_with_a_loop_over_all_triangles() {
    let mut rng = Pcg64Mcg::seed_from_u64(1);
    for (round, scale) in [1.0, 1.0, 1e-30, 1e30, 1e-44].into_iter().enumerate() {
        let size = [1.0, 0.1, 0.3, 0.3, 0.3][round];
        let corners = (0..400).flat_map(|_| {
            let c = vector(&mut rng);
            [0; 3].map(|_| (c + size * vector(&mut rng)) * scale)
        });
        let bvh = Bvh::build(&soup(corners.collect()));
        let mut hit = 0;
        for _ in 0..12 {
            let origin = 2.0 * scale * vector(&mut rng);
            hit += agree(&bvh, origin, &fan(&mut rng, 16));
            let aimed: Vec<Vec3> = (0..16).map(|_| scale * vector(&mut rng) - origin).collect();
            hit += agree(&bvh, origin, &aimed);
        }
        assert!(hit > 20, "{hit} hits at scale {scale:e}");
    }
}

#[test]
fn grids_slivers_and_repeated_faces_agree_with_a_loop() {
    let mut rng = Pcg64Mcg::seed_from_u64(2);
    let coordinate = |rng: &mut Pcg64Mcg| f32::from(rng.random_range(-3i8..=3));
    for round in 0..6 {
        // Corners on few integers: shared, coplanar, parallel to the axes, repeated and without area.
        let corners: Vec<Vec3> = (0..900).map(|_| Vec3::from_array([0; 3].map(|_| coordinate(&mut rng)))).collect();
        let mut corners = if round < 3 {
            corners
        } else {
            // Slivers: the third corner all but on the edge of the others.
            corners.chunks(3).flat_map(|c| [c[0], c[1], c[0].lerp(c[1], 0.3) + 1e-6 * c[2]]).collect()
        };
        corners.extend_from_within(..300);
        let mesh = soup(corners);
        let bvh = Bvh::build(&mesh);
        assert_eq!(bvh.len(), mesh.len() - mesh.degenerate());
        let mut hit = 0;
        for _ in 0..20 {
            // From grid points, half of them off the grid's planes, along axes, diagonals and edges.
            let origin = Vec3::from_array([0; 3].map(|_| coordinate(&mut rng) + [0.0, 0.5][round % 2]));
            let to_grid: Vec<Vec3> = (0..32)
                .map(|i| {
                    let p = Vec3::from_array([0; 3].map(|_| coordinate(&mut rng)));
                    if i % 2 == 0 { p - origin } else { p }
                })
                .collect();
            hit += agree(&bvh, origin, &to_grid);
        }
        assert!(hit > 100, "{hit} hits in round {round}");
    }
}

#[test]
fn hits_are_where_exact_geometry_has_them() {
    let mut rng = Pcg64Mcg::seed_from_u64(3);
    let corners: Vec<Vec3> = (0..300).flat_map(|_| [0; 3].map(|_| vector(&mut rng))).collect();
    let mesh = soup(corners);
    let bvh = Bvh::build(&mesh);
    let (mut same, mut hit) = (0, 0);
    for _ in 0..2000 {
        let origin = 2.0 * vector(&mut rng);
        let ray = Ray { origin, direction: vector(&mut rng) - origin };
        let found = bvh.nearest(&ray, f32::INFINITY).unwrap_or(Hit::MISS);
        // Cramer's rule in f64 (Moeller and Trumbore 1997).
        let mut truth = (f64::INFINITY, TriangleId::NONE, DVec3::ZERO);
        for t in TriangleId::all(mesh.len()) {
            let [a, b, c] = mesh.corners(t).map(|p| p.as_dvec3());
            let (d, e, f, s) = (ray.direction.as_dvec3(), b - a, c - a, ray.origin.as_dvec3() - a);
            let det = d.cross(f).dot(e);
            let at = DVec3::new(s.cross(e).dot(f), d.cross(f).dot(s), s.cross(e).dot(d)) / det;
            if at.x > 0.0 && at.x < truth.0 && at.y >= 0.0 && at.z >= 0.0 && at.y + at.z <= 1.0 {
                truth = (at.x, t, at);
            }
        }
        if found.triangle == truth.1 {
            same += 1;
            if found.is_some() {
                hit += 1;
                let off = [found.t - to_f32(truth.0), found.u - to_f32(truth.2.y), found.v - to_f32(truth.2.z)];
                // The largest amplification by a grazing angle among these rays is about a thousand.
                assert!(off.iter().all(|o| o.abs() < 1e-4), "{ray:?}: {off:?}");
            }
        }
    }
    // A ray in two thousand may run so close to an edge that f32 sees it on the other side.
    assert!(same >= 1999 && hit > 500, "{same} of 2000 agree, {hit} hits");
}

/// Whether all faces of a convex mesh that a point lies on are turned to the eye: the point is not on the outline.
fn faces_alone(mesh: &Mesh, point: Vec3, eye: Vec3) -> bool {
    mesh.triangles.iter().all(|t| {
        let [a, b, c] = t.map(|i| mesh.positions[i as usize]);
        let normal = (b - a).cross(c - a).normalize();
        normal.dot(point - a).abs() > 1e-3 || normal.dot((eye - point).normalize()) > 0.05
    })
}

#[test]
fn rays_at_vertices_and_edges_never_pass_a_closed_mesh() {
    let mut rng = Pcg64Mcg::seed_from_u64(4);
    let far = Vec3::new(1000.0, -700.0, 400.0);
    let closed = [
        (icosphere(3, Vec3::ZERO), Vec3::ZERO, 0.8),
        (icosphere(2, far), far, 0.8),
        (cuboid(Vec3::splat(-1.0), Vec3::splat(1.0)), Vec3::ZERO, 0.99),
        (cuboid(far - Vec3::splat(1.0), far + Vec3::splat(0.7)), far, 0.6),
    ];
    for (mesh, centre, inside) in &closed {
        let bvh = Bvh::build(mesh);
        for &[a, b, c] in mesh.triangles.iter() {
            let [a, b, c] = [a, b, c].map(|i| mesh.positions[i as usize]);
            let targets = [a, b, c, (a + b) * 0.5, a.lerp(b, 0.125), b.lerp(c, rng.random()), c.lerp(a, rng.random())];
            let from_inside = *centre + *inside * 0.57 * vector(&mut rng);
            let outside = (a + b + c) / 3.0 + 20.0 * vector(&mut rng).normalize();
            for target in targets {
                for origin in [*centre, from_inside, outside] {
                    if origin == outside && !faces_alone(mesh, target, outside) {
                        continue;
                    }
                    let ray = Ray { origin, direction: target - origin };
                    let hit = bvh.nearest(&ray, f32::INFINITY);
                    assert!(hit.is_some(), "a ray from {origin} passed through {target}");
                    assert!((0.99..1.01).contains(&hit.unwrap().t), "{ray:?} met {hit:?}");
                }
            }
            for origin in [*centre, from_inside] {
                let directions = targets.map(|t| t - origin);
                let mut hits = [Hit::MISS; 7];
                tile::cast(&bvh, origin, &directions, &mut hits);
                assert!(hits.iter().all(Hit::is_some), "a tile's ray from {origin} passed");
            }
        }
    }
}

#[test]
fn one_triangle_both_faces_and_the_ends_of_the_range() {
    let bvh = Bvh::build(&soup(vec![Vec3::ZERO, Vec3::X, Vec3::Y]));
    let down = Ray { origin: Vec3::new(0.25, 0.5, 3.0), direction: Vec3::new(0.0, 0.0, -2.0) };
    let up = Ray { origin: Vec3::new(0.25, 0.5, -3.0), direction: Vec3::Z };
    let hit = Hit { triangle: TriangleId(0), t: 1.5, u: 0.25, v: 0.5 };
    assert_eq!(bvh.nearest(&down, f32::INFINITY), Some(hit));
    assert_eq!(down.at(1.5), Vec3::new(0.25, 0.5, 0.0));
    assert_eq!(bvh.nearest(&up, 3.0), Some(Hit { t: 3.0, ..hit }));
    assert_eq!(bvh.nearest(&up, 3f32.next_down()), None);
    for t_max in [f32::NAN, 0.0, -1.0, f32::NEG_INFINITY] {
        assert!(!bvh.occluded(&up, t_max), "{t_max}");
    }
    // It starts on the triangle, behind it, or runs in its plane.
    for (origin, direction) in [
        (Vec3::new(0.25, 0.25, 0.0), Vec3::Z),
        (Vec3::new(0.25, 0.25, 1.0), Vec3::Z),
        (Vec3::new(-1.0, 0.25, 0.0), Vec3::X),
    ] {
        assert_eq!(bvh.nearest(&Ray { origin, direction }, f32::INFINITY), None);
    }
}

#[test]
fn of_equally_near_triangles_the_lower_id_counts() {
    let face = [Vec3::ZERO, Vec3::X, Vec3::Y];
    // The repeats turned and mirrored, among others farther on.
    let mut corners = vec![Vec3::Z * -1.0, Vec3::X * 4.0 - Vec3::Z, Vec3::Y * 4.0 - Vec3::Z];
    for _ in 0..50 {
        corners.extend(face);
        corners.extend([face[1], face[2], face[0]]);
        corners.extend([face[0], face[2], face[1]]);
    }
    let bvh = Bvh::build(&soup(corners));
    let ray = Ray { origin: Vec3::new(0.2, 0.3, 1.0), direction: Vec3::NEG_Z };
    assert_eq!(bvh.nearest(&ray, f32::INFINITY).unwrap().triangle, TriangleId(1));
    assert_eq!(agree(&bvh, ray.origin, &[ray.direction; 20]), 20);
}

#[test]
fn nothing_to_hit_is_never_hit() {
    let point = soup(vec![Vec3::ONE; 3]);
    let line = soup(vec![Vec3::ZERO, Vec3::ONE, 2.0 * Vec3::ONE, Vec3::ONE, Vec3::ONE, Vec3::X]);
    let none = mesh(Vec::new(), Vec::new());
    let infinite = soup(vec![Vec3::ZERO, Vec3::X * f32::INFINITY, Vec3::Y]);
    for mesh in [point, line, none, infinite] {
        let bvh = Bvh::build(&mesh);
        assert!(bvh.is_empty() && bvh.bytes() == 0, "{mesh:?}");
        assert_eq!(agree(&bvh, Vec3::ZERO, &[Vec3::ONE, Vec3::X, Vec3::NAN]), 0);
    }
}

#[test]
fn rays_that_are_none_meet_nothing_and_spoil_no_tile() {
    let mesh = icosphere(1, Vec3::ZERO);
    let bvh = Bvh::build(&mesh);
    let bad = [Vec3::ZERO, Vec3::NAN, Vec3::new(f32::INFINITY, 1.0, 0.0), Vec3::new(1.0, f32::NAN, 0.0)];
    let mut directions = vec![Vec3::new(0.3, 0.2, 1.0); 20];
    directions[3..7].copy_from_slice(&bad);
    assert_eq!(agree(&bvh, Vec3::ZERO, &directions), 16);
    assert_eq!(agree(&bvh, Vec3::ZERO, &bad), 0);
    for origin in [Vec3::NAN, Vec3::INFINITY, Vec3::new(0.0, f32::MAX, 0.0), Vec3::new(f32::NEG_INFINITY, 0.0, 0.0)] {
        assert_eq!(agree(&bvh, origin, &[-origin, Vec3::X, Vec3::NEG_Y]), 0, "{origin}");
    }
    // As far away as is allowed, and with the shortest and longest directions.
    let tiny = f32::from_bits(1);
    for direction in [Vec3::Z * tiny, Vec3::Z * f32::MAX, Vec3::new(tiny, -tiny, 1.0), Vec3::new(1e-38, 0.0, -1.0)] {
        agree(&bvh, Vec3::ZERO, &[direction]);
    }
    assert_eq!(agree(&bvh, Vec3::Z * 1e28, &[Vec3::NEG_Z]), 1);
}

#[test]
fn many_like_boxes_do_not_stall_the_build() {
    let strip = (0..60_000).flat_map(|i| {
        let x = i as f32;
        [Vec3::new(x, 0.0, 0.0), Vec3::new(x + 1.0, 0.0, 0.0), Vec3::new(x, 1.0, 0.0)]
    });
    let repeated = (0..60_000).flat_map(|_| [Vec3::ZERO, Vec3::X, Vec3::Y]);
    for corners in [strip.collect::<Vec<_>>(), repeated.collect()] {
        let bvh = Bvh::build(&soup(corners));
        assert!(depth(&bvh, bvh.root) <= DEPTH);
        assert_eq!(agree(&bvh, Vec3::new(0.2, 0.3, 9.0), &[Vec3::NEG_Z]), 1);
    }
}

/// Nodes on the longest way down.
fn depth(bvh: &Bvh, node: u32) -> usize {
    let node = &bvh.nodes[node as usize];
    let below = (0..node.count.len()).filter(|&i| node.count[i] != EMPTY && node.count[i] == 0);
    1 + below.map(|i| depth(bvh, node.child[i])).max().unwrap_or(0)
}

#[test]
fn trees_deeper_than_the_stack_are_balanced() {
    // Each triangle holds all that follow: clustering makes a chain of them.
    let nested = |n: i32| (0..n).flat_map(|i| [Vec3::ZERO, Vec3::X, Vec3::Y].map(|p| p * 0.8f32.powi(i))).collect();
    let bvh = Bvh::build(&soup(nested(380)));
    let depth = depth(&bvh, bvh.root);
    assert!(depth > 20 && depth <= DEPTH, "{depth} levels");
    for at in [Vec3::new(0.1, 0.1, 0.0), Vec3::new(1e-9, 1e-9, 0.0), Vec3::splat(1e-38)] {
        agree(&bvh, Vec3::Z, &[at - Vec3::Z, at * 0.5 - Vec3::Z]);
    }
}

#[test]
fn a_tree_in_chunks_hits_what_a_whole_one_hits() {
    let mut rng = Pcg64Mcg::seed_from_u64(5);
    let scattered: Vec<Vec3> =
        (0..3000).flat_map(|_| [vector(&mut rng); 3].map(|c| c + 0.05 * vector(&mut rng))).collect();
    let (sphere, repeated) = (icosphere(4, Vec3::ONE), soup([Vec3::ZERO, Vec3::X, Vec3::Y].repeat(500)));
    for mesh in [soup(scattered), sphere, repeated] {
        let whole = Bvh::build(&mesh);
        for most in [1, 5, 100, mesh.len() - 1] {
            let chunks = Bvh::build_in_chunks(&mesh, most);
            assert_eq!(chunks.len(), whole.len());
            let levels = depth(&chunks, chunks.root);
            assert!(levels <= depth(&whole, whole.root) + 16 && levels <= DEPTH, "{levels} levels of chunks of {most}");
            for _ in 0..6 {
                let origin = 2.0 * vector(&mut rng);
                let directions: Vec<Vec3> = (0..16).map(|_| vector(&mut rng) - origin).collect();
                agree(&chunks, origin, &directions);
                let bits = |b: &Bvh| {
                    directions
                        .clone()
                        .into_iter()
                        .map(|direction| bits(b.nearest(&Ray { origin, direction }, f32::INFINITY)))
                        .collect::<Vec<_>>()
                };
                assert_eq!(bits(&chunks), bits(&whole));
            }
        }
    }
}

#[test]
fn a_tile_is_ordered_in_blocks() {
    let order = tile::order(32, 8);
    assert_eq!(order.len(), 256);
    for block in order.chunks(16) {
        let UVec2 { x, y } = block[0];
        assert!(block.iter().all(|at| (x..x + 4).contains(&at.x) && (y..y + 4).contains(&at.y)), "{block:?}");
    }
    let mut odd = tile::order(5, 3);
    odd.sort_unstable_by_key(|at| (at.y, at.x));
    assert!(odd.into_iter().eq((0..3).flat_map(|y| (0..5).map(move |x| UVec2::new(x, y)))));
    assert!(tile::order(0, 7).is_empty());
}
