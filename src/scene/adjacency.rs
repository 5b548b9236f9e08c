//! Which triangles touch across an edge. Vertices at the same place count as one, so that meshes whose faces share no
//! vertices (as textured OBJ files write them) still hang together.

use glam::Vec3;

use super::Mesh;
use crate::base::ids::TriangleId;

/// Neighbours across edges, as compressed rows.
#[derive(Debug, Clone, PartialEq, Eq)]
pub struct Adjacency {
    starts: Vec<u32>,
    neighbours: Vec<TriangleId>,
}

impl Adjacency {
    /// The neighbours of a mesh. Where more than two triangles meet at an edge, they are linked in a chain by id: all
    /// are reached, and the number of links stays linear.
    pub fn of(mesh: &Mesh) -> Adjacency {
        let canonical = weld(&mesh.positions);
        let mut edges: Vec<(u32, u32, TriangleId)> = Vec::with_capacity(3 * mesh.len());
        for (t, corners) in mesh.triangles.iter().enumerate() {
            let [a, b, c] = corners.map(|i| canonical[i as usize]);
            let sides = [(a, b), (b, c), (c, a)].into_iter().filter(|(p, q)| p != q);
            edges.extend(sides.map(|(p, q)| (p.min(q), p.max(q), t as TriangleId)));
        }
        edges.sort_unstable();
        edges.dedup();
        let links = || {
            let same = |w: &&[(u32, u32, TriangleId)]| (w[0].0, w[0].1) == (w[1].0, w[1].1);
            edges.windows(2).filter(same).map(|w| (w[0].2, w[1].2))
        };
        let mut starts = vec![0u32; mesh.len() + 1];
        for (a, b) in links() {
            starts[a as usize + 1] += 1;
            starts[b as usize + 1] += 1;
        }
        for i in 0..mesh.len() {
            starts[i + 1] += starts[i];
        }
        let mut neighbours = vec![0; starts[mesh.len()] as usize];
        let mut next = starts.clone();
        for (a, b) in links() {
            for (from, to) in [(a, b), (b, a)] {
                let slot = &mut next[from as usize];
                neighbours[*slot as usize] = to;
                *slot += 1;
            }
        }
        Adjacency { starts, neighbours }
    }

    /// The neighbours of a triangle.
    pub fn neighbours(&self, t: TriangleId) -> &[TriangleId] {
        let t = t as usize;
        &self.neighbours[self.starts[t] as usize..self.starts[t + 1] as usize]
    }
}

/// For every vertex the first one at the same place.
fn weld(positions: &[Vec3]) -> Vec<u32> {
    // Adding 0 makes -0 and 0 the same bits.
    let bits = |i: &u32| (positions[*i as usize] + Vec3::ZERO).to_array().map(f32::to_bits);
    let mut order: Vec<u32> = (0..positions.len() as u32).collect();
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

    #[test]
    fn two_halves_of_a_quad_touch_with_or_without_shared_vertices() {
        for shared in [true, false] {
            let a = Adjacency::of(&quad(shared));
            assert_eq!((a.neighbours(0), a.neighbours(1)), (&[1][..], &[0][..]), "shared {shared}");
        }
    }

    #[test]
    fn a_fan_of_five_around_one_edge_is_a_chain() {
        let mut v = vec![DVec3::ZERO, DVec3::Z];
        v.extend((0..5).map(|i| DVec3::new(f64::from(i).cos(), f64::from(i).sin(), 0.0)));
        let a = Adjacency::of(&Mesh::new(&v, (0..5).map(|i| [0, 1, 2 + i]).collect()).unwrap());
        assert_eq!(a.neighbours(0), [1]);
        assert_eq!(a.neighbours(2), [1, 3]);
        assert_eq!(a.neighbours(4), [3]);
    }

    #[test]
    fn a_triangle_on_one_vertex_has_no_neighbour() {
        let v = [DVec3::ZERO, DVec3::X, DVec3::Y];
        let a = Adjacency::of(&Mesh::new(&v, vec![[0, 0, 0], [0, 1, 2]]).unwrap());
        assert!(a.neighbours(0).is_empty() && a.neighbours(1).is_empty());
    }
}
