//! A tree that lies in bytes, such as a file's: [`Chunks`](super::hierarchy::Chunks) writes one. Nothing in
//! the bytes is trusted: nodes that were not built here could run in circles or point anywhere, and are refused.

use std::ops::Range;

use super::bvh::{Bvh, DEPTH};
use super::slab::EMPTY;
use crate::base::Array;
use crate::base::array::SharedBytes;

/// Where nodes and triangles of a tree lie in its bytes.
#[derive(Debug, Clone, PartialEq)]
pub struct Stored {
    /// The nodes, as they were written.
    pub nodes: Range<usize>,
    /// The triangles, as they were written.
    pub triangles: Range<usize>,
    /// The number of the root node.
    pub root: u32,
    /// The factor that coordinates were multiplied by.
    pub scale: f64,
}

impl Bvh {
    /// The tree that lies in these bytes, over a mesh of `count` triangles.
    ///
    /// # Errors
    /// In words, if the bytes hold no such tree.
    pub fn view(bytes: &SharedBytes, at: &Stored, count: usize) -> Result<Bvh, String> {
        let nodes = Array::view(bytes, at.nodes.clone()).map_err(|found| format!("nodes: {found}"))?;
        let triangles = Array::view(bytes, at.triangles.clone()).map_err(|found| format!("leaves: {found}"))?;
        let bvh = Bvh { nodes, triangles, root: at.root, scale: at.scale };
        bvh.check(count).map(|()| bvh)
    }

    fn check(&self, count: usize) -> Result<(), String> {
        let (nodes, triangles) = (&self.nodes[..], &self.triangles[..]);
        // A power of two: nothing but an exponent.
        if !(self.scale.is_normal() && self.scale > 0.0 && self.scale.to_bits() << 12 == 0) {
            return Err(format!("its scale is {:e}, which is not a power of two", self.scale));
        }
        if let Some(at) = triangles.iter().position(|t| t.id.index() >= count) {
            return Err(format!("leaf triangle {at} is triangle {}, but the mesh has {count}", triangles[at].id));
        }
        if nodes.is_empty() || triangles.is_empty() {
            let none = nodes.is_empty() && triangles.is_empty();
            return if none { Ok(()) } else { Err("it has nodes or triangles, but not both".to_owned()) };
        }
        // Depth first, each node with its level. A node with two parents is met twice, so that more nodes are met than
        // there are.
        let mut to_do = vec![(self.root, 1)];
        let mut met = 0;
        while let Some((at, level)) = to_do.pop() {
            let node = nodes.get(at as usize).ok_or_else(|| format!("it wants node {at} of {}", nodes.len()))?;
            met += 1;
            if level > DEPTH || met > nodes.len() {
                return Err(format!("its nodes are not a tree of at most {DEPTH} levels"));
            }
            for (&child, &count) in node.child.iter().zip(&node.count).filter(|(_, count)| **count != EMPTY) {
                if count == 0 {
                    to_do.push((child, level + 1));
                } else if child as usize + usize::from(count) > triangles.len() {
                    return Err(format!("node {at} wants {count} triangles from {child} of {}", triangles.len()));
                }
            }
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use std::sync::Arc;

    use glam::DVec3;

    use super::*;
    use crate::base::convert::to_u32;
    use crate::scene::Mesh;
    use crate::trace::hierarchy::Chunks;
    use crate::trace::slab::Node;

    /// A height field of `2 n^2` triangles.
    fn field(n: u32) -> Mesh {
        let height = |i: u32| f64::from(i * i % 97) / 50.0;
        let vertices: Vec<DVec3> = (0..(n + 1) * (n + 1))
            .map(|i| DVec3::new(f64::from(i % (n + 1)), f64::from(i / (n + 1)), height(i % 1000)))
            .collect();
        let cell = |i: u32| i / n * (n + 1) + i % n;
        let triangles = (0..n * n).map(cell).flat_map(|i| [[i, i + 1, i + n + 1], [i + 1, i + n + 2, i + n + 1]]);
        Mesh::new(&vertices, triangles.collect()).unwrap()
    }

    /// Bytes that begin on a multiple of 64, as a mapped file does.
    fn shared(bytes: &[u8]) -> SharedBytes {
        struct Lines(Vec<[Node; 1]>);
        impl AsRef<[u8]> for Lines {
            fn as_ref(&self) -> &[u8] {
                bytemuck::cast_slice(&self.0)
            }
        }
        let mut lines = vec![[Node::VACANT]; bytes.len().div_ceil(128)];
        bytemuck::cast_slice_mut(&mut lines)[..bytes.len()].copy_from_slice(bytes);
        Arc::new(Lines(lines))
    }

    fn written(mesh: &Mesh) -> (Vec<u8>, Stored) {
        let mut bytes = Vec::new();
        let mut put = |some: &[u8]| -> Result<(), String> {
            bytes.extend_from_slice(some);
            Ok(())
        };
        let ordered = Chunks::of(mesh).nodes(&mut put).unwrap();
        ordered.triangles(&mut put).unwrap();
        let nodes = bytes.len() - 40 * mesh.len();
        let at =
            Stored { nodes: 0..nodes, triangles: nodes..bytes.len(), root: ordered.root(), scale: ordered.scale() };
        (bytes, at)
    }

    #[test]
    fn what_was_written_is_the_tree_that_was_built() {
        let mesh = field(30);
        let (bytes, at) = written(&mesh);
        let (view, built) = (Bvh::view(&shared(&bytes), &at, mesh.len()).unwrap(), Bvh::build(&mesh));
        assert_eq!(bytemuck::cast_slice::<_, u8>(&view.nodes), bytemuck::cast_slice::<_, u8>(&built.nodes));
        assert_eq!(bytemuck::cast_slice::<_, u8>(&view.triangles), bytemuck::cast_slice::<_, u8>(&built.triangles));
        assert_eq!((view.root, view.scale, view.held()), (built.root, built.scale, 0));
        assert!(built.held() >= built.bytes() && view.bytes() == built.bytes());
    }

    #[test]
    fn what_is_no_tree_is_refused() {
        let mesh = field(30);
        let (bytes, at) = written(&mesh);
        let refusal = |bytes: &[u8], at: &Stored, count| match Bvh::view(&shared(bytes), at, count) {
            Ok(_) => "it is a tree".to_owned(),
            Err(found) => found,
        };
        let count = mesh.len();
        assert_eq!(refusal(&bytes, &at, count), "it is a tree");
        assert!(refusal(&bytes, &at, count - 1).contains("but the mesh has 1799"));
        for scale in [0.0, -1.0, f64::NAN, f64::INFINITY, 0.75, f64::from_bits(1)] {
            assert!(refusal(&bytes, &Stored { scale, ..at.clone() }, count).contains("not a power of two"), "{scale}");
        }
        let root = to_u32(at.nodes.end / 128);
        assert!(refusal(&bytes, &Stored { root, ..at.clone() }, count).contains("it wants node"));
        assert!(refusal(&bytes, &Stored { triangles: 0..0, ..at.clone() }, count).contains("but not both"));
        assert!(refusal(&bytes, &Stored { nodes: 0..64, ..at.clone() }, count).contains("nodes: 64 bytes"));
        let short = Stored { triangles: at.triangles.start..at.triangles.end - 40, ..at.clone() };
        assert!(refusal(&bytes, &short, count).contains("triangles from"));
        // The root's children become the root itself: a circle, and then one child twice.
        for (child, words) in [(0u32, "not a tree"), (u32::MAX, "it wants node")] {
            let mut bytes = bytes.clone();
            bytes[96..100].copy_from_slice(&child.to_ne_bytes());
            bytes[112] = 0;
            assert!(refusal(&bytes, &at, count).contains(words));
        }
        let mut twice = bytes.clone();
        twice.copy_within(96..100, 100);
        twice[113] = twice[112];
        assert!(refusal(&twice, &at, count).contains("not a tree"), "{}", refusal(&twice, &at, count));
    }
}
