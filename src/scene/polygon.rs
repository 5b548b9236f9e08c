//! Cuts polygons into triangles.

use earcut::Earcut;
use glam::{DVec2, DVec3, Vec3};

/// Faces of more corners are no surfaces that anybody made, and would take long: they stay fans.
const MOST: usize = 1 << 12;

/// A face as a fan around its first corner.
pub(super) fn fan(corners: &[u32]) -> impl Iterator<Item = [u32; 3]> {
    let first = corners.first().copied().unwrap_or(0);
    corners.windows(2).skip(1).map(move |pair| [first, pair[0], pair[1]])
}

/// Replaces a fan that leaves its polygon, or covers a part of it twice, by triangles that cover the polygon and no more, as many of
/// them; those that are not needed have no area. A fan that covers it stays, and so does that of a polygon that crosses itself.
pub(super) fn cut(positions: &[Vec3], triangles: &mut [[u32; 3]]) {
    let (Some(&[first, second, _]), at) = (triangles.first(), |i: u32| positions[i as usize].as_dvec3()) else {
        return;
    };
    if triangles.len() > MOST {
        return;
    }
    let corners: Vec<u32> = [first, second].into_iter().chain(triangles.iter().map(|t| t[2])).collect();
    let normal = normal(&corners, at);
    let facing = |[a, b, c]: [u32; 3]| (at(b) - at(a)).cross(at(c) - at(a)).dot(normal);
    // Rounding may turn a triangle that has no area.
    let slight = -1e-9 * normal.length_squared();
    if triangles.iter().all(|&t| facing(t) >= slight) {
        return;
    }
    let (x, y) = normal.normalize_or(DVec3::Z).any_orthonormal_pair();
    let origin = at(first);
    let flat = corners.iter().map(|&corner| DVec2::new((at(corner) - origin).dot(x), (at(corner) - origin).dot(y)));
    let mut found: Vec<u32> = Vec::new();
    Earcut::new().earcut(flat.map(|p| p.to_array()), &[], &mut found);
    let ears = found.as_chunks::<3>().0;
    if ears.is_empty() || ears.len() > triangles.len() {
        return;
    }
    let corner = |at: u32| corners[at as usize];
    for (number, triangle) in triangles.iter_mut().enumerate() {
        let [a, b, c] = ears.get(number).map_or([first; 3], |ear| ear.map(corner));
        *triangle = if facing([a, b, c]) < 0.0 { [a, c, b] } else { [a, b, c] };
    }
}

/// Twice the area of a polygon along its normal (Newell's method: Sutherland, Sproull and Schumacker 1974).
fn normal(corners: &[u32], at: impl Fn(u32) -> DVec3) -> DVec3 {
    let around = corners.iter().zip(corners.iter().cycle().skip(1));
    let origin = corners.first().map_or(DVec3::ZERO, |&first| at(first));
    around.map(|(&a, &b)| (at(a) - origin).cross(at(b) - origin)).sum()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn area(corners: &[Vec3]) -> (f64, f64, usize) {
        let order: Vec<u32> = (0..corners.len() as u32).collect();
        let mut triangles: Vec<[u32; 3]> = fan(&order).collect();
        cut(corners, &mut triangles);
        let normal = normal(&order, |i| corners[i as usize].as_dvec3());
        let of = |t: [u32; 3]| {
            let [a, b, c] = t.map(|i| corners[i as usize].as_dvec3());
            (b - a).cross(c - a).dot(normal.normalize())
        };
        let (sum, most) = triangles.iter().fold((0.0, 0.0), |(sum, all), &t| (sum + of(t), all + of(t).abs()));
        (sum / 2.0, most / 2.0, triangles.len())
    }

    #[test]
    fn triangles_cover_their_polygon_and_no_more() {
        let l = [[0, 0], [16, 0], [16, 4], [4, 4], [4, 16], [0, 16]];
        let comb = [[0, 0], [9, 0], [9, 5], [8, 1], [6, 1], [5, 5], [4, 1], [2, 1], [1, 5]];
        let square = [[0, 0], [2, 0], [2, 2], [1, 2], [0, 2]];
        for (shape, expected) in [(&l[..], 112.0), (&comb[..], 0.0), (&square[..], 4.0)] {
            for turn in 0..shape.len() {
                for backwards in [false, true] {
                    let mut shape = shape.to_vec();
                    shape.rotate_left(turn);
                    if backwards {
                        shape.reverse();
                    }
                    // In a plane that leans.
                    let lean = |[x, y]: [i32; 2]| Vec3::new(x as f32, y as f32 * 0.6, y as f32 * 0.8);
                    let corners: Vec<Vec3> = shape.into_iter().map(lean).collect();
                    let (sum, most, count) = area(&corners);
                    assert!((sum - most).abs() < 1e-3 && sum > 0.0, "{corners:?}: {sum} {most}");
                    assert!(expected == 0.0 || (sum - expected).abs() < 1e-3, "{corners:?}: {sum}");
                    assert_eq!(count, corners.len() - 2);
                }
            }
        }
    }

    #[test]
    fn a_fan_that_covers_its_polygon_stays() {
        let corners = [[0.0, 0.0], [1.0, 0.0], [1.5, 1.0], [0.0, 2.0]].map(|[x, y]| Vec3::new(x, y, 0.1 * x));
        let mut triangles: Vec<[u32; 3]> = fan(&[0, 1, 2, 3]).collect();
        cut(&corners, &mut triangles);
        assert_eq!(triangles, [[0, 1, 2], [0, 2, 3]]);
    }
}
