//! Splits triangles in space: into halves of equal number across the longest side of the box around their middles, and the
//! halves again, until no chunk is too large.

use glam::Vec3;

use crate::base::ids::TriangleId;
use crate::scene::Mesh;

/// A triangle and the middle of its corners.
#[derive(Debug, Clone, Copy)]
struct Middle {
    at: Vec3,
    id: TriangleId,
}

/// The triangles of a mesh, chunk after chunk. There are 2^n chunks, in the order of the halves.
#[derive(Debug, PartialEq)]
pub(super) struct Split {
    /// The triangles, ascending within each chunk.
    pub ids: Vec<TriangleId>,
    /// Where each chunk ends in `ids`.
    pub ends: Vec<usize>,
}

/// Splits the `count` triangles of a mesh that have an area into chunks of at most `most`.
pub(super) fn split(mesh: &Mesh, count: usize, most: usize) -> Split {
    let mut chunks = 1;
    while count.div_ceil(chunks) > most {
        chunks *= 2;
    }
    let found = TriangleId::all(mesh.len()).filter(|&t| mesh.normal(t).is_some());
    let mut ids: Vec<TriangleId> = Vec::with_capacity(if chunks == 1 { count } else { 0 });
    if chunks == 1 {
        ids.extend(found);
    } else {
        let mut middles = Vec::with_capacity(count);
        middles.extend(found.map(|id| Middle { at: mesh.corners(id).into_iter().sum::<Vec3>() / 3.0, id }));
        halve(&mut middles, chunks);
        // In place: the ids take over the memory of the middles, and the rest of it is given back.
        ids = middles.into_iter().map(|m| m.id).collect();
        ids.shrink_to_fit();
    }
    let mut ends = Vec::with_capacity(chunks);
    if count > 0 {
        place(count, chunks, 0, &mut ends);
    }
    let mut start = 0;
    for &end in &ends {
        ids[start..end].sort_unstable();
        start = end;
    }
    Split { ids, ends }
}

/// Puts the triangles of the first half of the chunks before those of the second half, and goes on in both halves.
fn halve(middles: &mut [Middle], chunks: usize) {
    if chunks < 2 || middles.len() < 2 {
        return;
    }
    let low = middles.iter().fold(Vec3::INFINITY, |low, m| low.min(m.at));
    let high = middles.iter().fold(Vec3::NEG_INFINITY, |high, m| high.max(m.at));
    let axis = (high - low).max_position();
    let half = middles.len() / 2;
    // Ids decide between equals, so that a triangle's half does not depend on the order of the search.
    middles.select_nth_unstable_by(half, |a, b| a.at[axis].total_cmp(&b.at[axis]).then(a.id.cmp(&b.id)));
    let (left, right) = middles.split_at_mut(half);
    halve(left, chunks / 2);
    halve(right, chunks / 2);
}

/// Appends where the chunks end that share out `count` triangles from `start` on.
fn place(count: usize, chunks: usize, start: usize, ends: &mut Vec<usize>) {
    if chunks < 2 || count < 2 {
        return ends.push(start + count);
    }
    let half = count / 2;
    place(half, chunks / 2, start, ends);
    place(count - half, chunks / 2, start + half, ends);
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
    fn chunks_are_apart_and_none_is_too_large() {
        for (n, most, chunks) in [(1000, 1000, 1), (1000, 999, 2), (1000, 300, 4), (1001, 126, 8), (5, 1, 8)] {
            let mesh = scattered(n);
            let Split { ids, ends } = split(&mesh, mesh.len(), most);
            assert!(ends.len() <= chunks && ends.last() == Some(&ids.len()), "{n} {most}: {ends:?}");
            let mut all = ids.clone();
            all.sort_unstable();
            assert!(all.into_iter().eq(TriangleId::all(mesh.len())));
            let (mut start, mut before) = (0, f32::NEG_INFINITY);
            for end in ends {
                let chunk = &ids[start..end];
                assert!(!chunk.is_empty() && chunk.len() <= most && chunk.is_sorted());
                let x = |t: &TriangleId| mesh.corners(*t)[0].x;
                let low = chunk.iter().map(x).fold(f32::INFINITY, f32::min);
                assert!(low > before, "chunks overlap");
                (start, before) = (end, chunk.iter().map(x).fold(low, f32::max));
            }
        }
    }

    #[test]
    fn nothing_is_in_no_chunk() {
        let flat = Mesh::new(&[DVec3::ZERO; 3], vec![[0, 1, 2]]).unwrap();
        assert_eq!(split(&flat, 0, 10), Split { ids: Vec::new(), ends: Vec::new() });
    }
}
