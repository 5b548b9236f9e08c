//! Splitting triangles in space: in halves of equal number across the longest side of their middles' box, and these
//! again, until no part is too large.

use glam::Vec3;

use crate::base::ids::TriangleId;
use crate::scene::Mesh;

/// A triangle and the middle of its corners.
#[derive(Debug, Clone, Copy)]
struct Middle {
    at: Vec3,
    id: TriangleId,
}

/// The `count` triangles of a mesh that have an area, in parts of at most `most`, and where each part ends. There are
/// 2^n parts, in the order of the halves; the triangles of each are ascending.
pub(super) fn split(mesh: &Mesh, count: usize, most: usize) -> (Vec<TriangleId>, Vec<usize>) {
    let mut parts = 1;
    while count.div_ceil(parts) > most {
        parts *= 2;
    }
    let found = (0..mesh.len() as TriangleId).filter(|&t| mesh.normal(t).is_some());
    let mut ids: Vec<TriangleId> = Vec::with_capacity(if parts == 1 { count } else { 0 });
    if parts == 1 {
        ids.extend(found);
    } else {
        let mut middles = Vec::with_capacity(count);
        middles.extend(found.map(|id| Middle { at: mesh.corners(id).into_iter().sum::<Vec3>() / 3.0, id }));
        halve(&mut middles, parts);
        // In place: the ids take the room of the middles, and what is left of it is given back.
        ids = middles.into_iter().map(|m| m.id).collect();
        ids.shrink_to_fit();
    }
    let mut ends = Vec::with_capacity(parts);
    if count > 0 {
        place(count, parts, 0, &mut ends);
    }
    let mut start = 0;
    for &end in &ends {
        ids[start..end].sort_unstable();
        start = end;
    }
    (ids, ends)
}

/// Puts those of the first half of the parts before those of the second, and so on in both.
fn halve(middles: &mut [Middle], parts: usize) {
    if parts < 2 || middles.len() < 2 {
        return;
    }
    let low = middles.iter().fold(Vec3::INFINITY, |low, m| low.min(m.at));
    let high = middles.iter().fold(Vec3::NEG_INFINITY, |high, m| high.max(m.at));
    let axis = (high - low).max_position();
    let half = middles.len() / 2;
    // Ids decide between equals, so that which half a triangle is in does not depend on how it is found.
    middles.select_nth_unstable_by(half, |a, b| a.at[axis].total_cmp(&b.at[axis]).then(a.id.cmp(&b.id)));
    let (left, right) = middles.split_at_mut(half);
    halve(left, parts / 2);
    halve(right, parts / 2);
}

/// Where the parts of `count` triangles end that begin at `start`.
fn place(count: usize, parts: usize, start: usize, ends: &mut Vec<usize>) {
    if parts < 2 || count < 2 {
        return ends.push(start + count);
    }
    let half = count / 2;
    place(half, parts / 2, start, ends);
    place(count - half, parts / 2, start + half, ends);
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// `n` triangles on a line, in any order but along it.
    fn scattered(n: u32) -> Mesh {
        let place = |i: u32| f64::from((i * 7919) % n);
        let corners = |i| [DVec3::ZERO, DVec3::Y, DVec3::Z].map(|p| p + DVec3::X * 10.0 * place(i));
        let vertices: Vec<DVec3> = (0..n).flat_map(corners).collect();
        Mesh::new(&vertices, (0..n).map(|i| [3 * i, 3 * i + 1, 3 * i + 2]).collect()).unwrap()
    }

    #[test]
    fn parts_are_apart_and_none_is_too_large() {
        for (n, most, parts) in [(1000, 1000, 1), (1000, 999, 2), (1000, 300, 4), (1001, 126, 8), (5, 1, 8)] {
            let mesh = scattered(n);
            let (ids, ends) = split(&mesh, mesh.len(), most);
            assert!(ends.len() <= parts && ends.last() == Some(&ids.len()), "{n} {most}: {ends:?}");
            let mut all = ids.clone();
            all.sort_unstable();
            assert!(all.into_iter().eq(0..n));
            let (mut start, mut before) = (0, f32::NEG_INFINITY);
            for end in ends {
                let part = &ids[start..end];
                assert!(!part.is_empty() && part.len() <= most && part.is_sorted());
                let x = |t: &u32| mesh.corners(*t)[0].x;
                let low = part.iter().map(x).fold(f32::INFINITY, f32::min);
                assert!(low > before, "parts overlap");
                (start, before) = (end, part.iter().map(x).fold(low, f32::max));
            }
        }
    }

    #[test]
    fn nothing_is_in_no_part() {
        let flat = Mesh::new(&[DVec3::ZERO; 3], vec![[0, 1, 2]]).unwrap();
        assert_eq!(split(&flat, 0, 10), (Vec::new(), Vec::new()));
    }
}
