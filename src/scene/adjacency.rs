//! The triangles that touch across an edge. Vertices at the same place count as one, so that meshes whose faces share no
//! vertices (as textured OBJ files write them) are still connected.

use std::ops::Range;

use glam::Vec3;

use super::Mesh;
use crate::base::Array;
use crate::base::array::SharedBytes;
use crate::base::convert::to_u32;
use crate::base::ids::TriangleId;

/// Neighbours across edges, as compressed rows.
#[derive(Debug, Clone, PartialEq)]
pub struct Adjacency {
    starts: Array<u32>,
    neighbours: Array<TriangleId>,
}

/// Sides of triangles that are sorted at a time: 96 MB of them.
const SIDES: usize = 1 << 23;

/// A side: its vertices, the lower first, and its triangle.
type Side = (u32, u32, TriangleId);

impl Adjacency {
    /// Bytes of memory that building takes besides the mesh for this many triangles and vertices, at most.
    pub fn building(triangles: u64, vertices: u64) -> u64 {
        let sides = (3 * triangles).min(SIDES as u64) * size_of::<Side>() as u64;
        // Starts twice and three neighbours; for a vertex the first at its place, and its place in the order or its sides.
        20 * triangles + 8 * vertices + sides
    }

    /// Finds the neighbours in a mesh. Where more than two triangles meet at an edge, they are linked in a chain by id:
    /// all are reached, and the number of links stays linear.
    pub fn of(mesh: &Mesh) -> Adjacency {
        Adjacency::of_some_at_a_time(mesh, SIDES)
    }

    /// Finds the neighbours with at most `most` sides sorted at a time, except for a vertex that has more.
    fn of_some_at_a_time(mesh: &Mesh, most: usize) -> Adjacency {
        let mut sides = Sides::of(mesh, most);
        let mut starts = vec![0u32; mesh.len() + 1];
        sides.links(|a, b| {
            starts[a.index() + 1] += 1;
            starts[b.index() + 1] += 1;
        });
        for i in 0..mesh.len() {
            starts[i + 1] += starts[i];
        }
        let mut neighbours = vec![TriangleId::NONE; starts[mesh.len()] as usize];
        let mut next = starts.clone();
        sides.links(|a, b| {
            for (from, to) in [(a, b), (b, a)] {
                let slot = &mut next[from.index()];
                neighbours[*slot as usize] = to;
                *slot += 1;
            }
        });
        Adjacency { starts: starts.into(), neighbours: neighbours.into() }
    }

    /// The neighbours that lie in these bytes, for a mesh of `count` triangles.
    ///
    /// # Errors
    /// In words, if the bytes hold no such rows.
    pub fn view(bytes: &SharedBytes, [starts, neighbours]: [Range<usize>; 2], count: usize) -> Result<Self, String> {
        let view = Adjacency { starts: Array::view(bytes, starts)?, neighbours: Array::view(bytes, neighbours)? };
        let (starts, neighbours) = (&view.starts[..], &view.neighbours[..]);
        let whole = starts.len() == count + 1
            && starts.first() == Some(&0)
            && starts.last().is_some_and(|&end| end as usize == neighbours.len());
        if !whole || !starts.is_sorted() {
            let (found, links) = (starts.len(), neighbours.len());
            return Err(format!("{found} rows of neighbours do not share out {links} over {count} triangles"));
        }
        match neighbours.iter().find(|t| t.index() >= count) {
            Some(beyond) => Err(format!("triangle {beyond} is said to be a neighbour, but there are {count}")),
            None => Ok(view),
        }
    }

    /// The arrays of a view: where each triangle's neighbours start, and the neighbours.
    pub fn arrays(&self) -> [&[u32]; 2] {
        [&self.starts, bytemuck::cast_slice(&self.neighbours)]
    }

    /// The neighbours of a triangle.
    pub fn neighbours(&self, t: TriangleId) -> &[TriangleId] {
        let (t, starts) = (t.index(), &self.starts[..]);
        &self.neighbours[starts[t] as usize..starts[t + 1] as usize]
    }
}

/// The sides of all triangles, sorted a range of lower vertices at a time.
struct Sides<'m> {
    mesh: &'m Mesh,
    canonical: Vec<u32>,
    ranges: Vec<Range<u32>>,
    /// The sides of the range `at`.
    some: Vec<Side>,
    at: Option<usize>,
}

impl<'m> Sides<'m> {
    fn of(mesh: &'m Mesh, most: usize) -> Self {
        let canonical = weld(&mesh.positions);
        let mut counts = vec![0u32; canonical.len()];
        for t in mesh.triangles.iter() {
            sides(&canonical, *t).for_each(|(low, _)| counts[low as usize] += 1);
        }
        let (mut ranges, mut start, mut held) = (Vec::new(), 0, 0);
        for (vertex, &count) in counts.iter().enumerate() {
            if held > 0 && held + count as usize > most {
                ranges.push(start..to_u32(vertex));
                (start, held) = (to_u32(vertex), 0);
            }
            held += count as usize;
        }
        ranges.push(start..to_u32(canonical.len()));
        Sides { mesh, canonical, ranges, some: Vec::with_capacity(most.min(3 * mesh.len())), at: None }
    }

    /// Calls `link` for every two triangles that are linked, in the order of the edges.
    fn links(&mut self, mut link: impl FnMut(TriangleId, TriangleId)) {
        for at in 0..self.ranges.len() {
            self.sort(at);
            let same = |w: &&[Side]| (w[0].0, w[0].1) == (w[1].0, w[1].1);
            self.some.windows(2).filter(same).for_each(|w| link(w[0].2, w[1].2));
        }
    }

    fn sort(&mut self, at: usize) {
        if self.at == Some(at) {
            return;
        }
        let range = self.ranges[at].clone();
        self.some.clear();
        for (t, corners) in TriangleId::all(self.mesh.len()).zip(self.mesh.triangles.iter()) {
            let own = sides(&self.canonical, *corners).filter(|(low, _)| range.contains(low));
            self.some.extend(own.map(|(low, high)| (low, high, t)));
        }
        self.some.sort_unstable();
        self.some.dedup();
        self.at = Some(at);
    }
}

/// The sides of a triangle that have a length.
fn sides(canonical: &[u32], corners: [u32; 3]) -> impl Iterator<Item = (u32, u32)> + use<> {
    let [a, b, c] = corners.map(|i| canonical[i as usize]);
    [(a, b), (b, c), (c, a)].into_iter().filter(|(p, q)| p != q).map(|(p, q)| (p.min(q), p.max(q)))
}

/// For every vertex, the first vertex at the same place.
fn weld(positions: &[Vec3]) -> Vec<u32> {
    // Adding 0 makes -0 and 0 the same bits.
    let bits = |i: &u32| (positions[*i as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..to_u32(positions.len())).collect();
    order.sort_unstable_by_key(|i| (bits(i), *i));
    let mut canonical = vec![0; positions.len()];
    let mut first = 0;
    for (k, &i) in order.iter().enumerate() {
        if k == 0 || bits(&order[k - 1]) != bits(&i) {
            first = i;
        }
        canonical[i as usize] = first;
    }
    canonical
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    fn quad(shared: bool) -> Mesh {
        let v = [(0., 0.), (1., 0.), (1., 1.), (0., 1.)].map(|(x, y)| DVec3::new(x, y, 0.0));
        if shared {
            Mesh::new(&v, vec![[0, 1, 2], [0, 2, 3]]).unwrap()
        } else {
            Mesh::new(&[v[0], v[1], v[2], v[0], v[2], v[3]], vec![[0, 1, 2], [3, 4, 5]]).unwrap()
        }
    }

    fn of(adjacency: &Adjacency, t: u32) -> &[u32] {
        bytemuck::cast_slice(adjacency.neighbours(TriangleId(t)))
    }

    #[test]
    fn two_halves_of_a_quad_touch_with_or_without_shared_vertices() {
        for shared in [true, false] {
            let a = Adjacency::of(&quad(shared));
            assert_eq!((of(&a, 0), of(&a, 1)), (&[1][..], &[0][..]), "shared {shared}");
        }
    }

    #[test]
    fn a_fan_of_five_around_one_edge_is_a_chain() {
        let mut v = vec![DVec3::ZERO, DVec3::Z];
        v.extend((0..5).map(|i| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), 0.0)));
        let a = Adjacency::of(&Mesh::new(&v, (0..5).map(|i| [0, 1, 2 + i]).collect()).unwrap());
        assert_eq!(of(&a, 0), [1]);
        assert_eq!(of(&a, 2), [1, 3]);
        assert_eq!(of(&a, 4), [3]);
    }

    #[test]
    fn a_triangle_on_one_vertex_has_no_neighbour() {
        let v = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let a = Adjacency::of(&Mesh::new(&v, vec![[0, 0, 0], [0, 1, 2]]).unwrap());
        assert!(of(&a, 0).is_empty() && of(&a, 1).is_empty());
    }

    #[test]
    fn how_many_sides_are_sorted_at_a_time_makes_no_difference() {
        let n = 20;
        let place = |i: u32| DVec3::new(f64::from(i % n), f64::from(i / n), 0.0);
        let vertices: Vec<DVec3> = (0..n * n).map(place).collect();
        let cells = (0..n * (n - 1)).filter(|i| i % n < n - 1);
        let mut triangles: Vec<[u32; 3]> = cells.flat_map(|i| [[i, i + 1, i + n], [i + 1, i + n + 1, i + n]]).collect();
        // A vertex with more sides than are sorted at a time.
        triangles.extend((1..300).map(|i| [0, i, i + 1]));
        let mesh = Mesh::new(&vertices, triangles).unwrap();
        let whole = Adjacency::of(&mesh);
        for most in [1, 7, 100, 1000] {
            assert_eq!(Adjacency::of_some_at_a_time(&mesh, most), whole, "{most}");
        }
    }

    #[test]
    fn what_are_no_rows_of_neighbours_is_refused() {
        let view = |words: &'static [u32], rows: usize, count| {
            let bytes: SharedBytes = std::sync::Arc::new(bytemuck::cast_slice::<u32, u8>(words));
            Adjacency::view(&bytes, [0..4 * rows, 4 * rows..4 * words.len()], count).map(|a| a.arrays()[1].to_vec())
        };
        assert_eq!(view(&[0, 1, 2, 1, 0], 3, 2), Ok(vec![1, 0]));
        for (words, rows, count) in [
            (&[0, 1, 2, 1, 0][..], 3, 3),
            (&[1, 1, 2, 1, 0], 3, 2),
            (&[0, 3, 2, 1, 0], 3, 2),
            (&[0, 1, 3, 1, 0], 3, 2),
            (&[0, 1, 2, 1, 2], 3, 2),
            (&[1], 0, 0),
        ] {
            assert!(view(words, rows, count).is_err(), "{words:?}");
        }
    }
}
