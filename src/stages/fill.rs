//! Fills triangles that have too little evidence with the materials of the nearest observed triangles. It goes from edge to
//! edge, level by level, so the result depends on the mesh and the observed materials alone.
//!
//! A few bits a triangle are held; the materials may lie in a mapped file.

use crate::base::Bits;
use crate::base::convert::to_f32;
use crate::base::ids::TriangleId;
use crate::scene::Material;
use crate::scene::adjacency::Adjacency;
use crate::scene::evidence::Filled;

/// The source of every triangle's material.
#[derive(Debug)]
pub(crate) struct Sources {
    observed: Bits,
    /// The observed triangles and those filled from neighbours.
    known: Bits,
    /// Whether any triangle was observed.
    any: bool,
}

/// Bytes of memory that filling holds for this many triangles.
pub(crate) fn bytes(triangles: u64) -> u64 {
    4 * Bits::bytes(triangles)
}

/// Fills the materials of all triangles that were not observed. Such a triangle takes the mean of its neighbours that are one
/// level nearer to an observed triangle; where edges lead to no observed triangle, it takes the mean of all observed ones.
/// Where nothing was observed, nothing changes.
pub(crate) fn fill(adjacency: &Adjacency, materials: &mut [[f32; Material::LEN]], observed: Bits) -> Sources {
    let mut known = observed.clone();
    let any = !observed.is_empty();
    if !any {
        return Sources { observed, known, any };
    }
    let mean = mean_of(observed.iter(), materials);
    let mut level = observed.clone();
    let mut next = Bits::new(materials.len());
    while !level.is_empty() {
        next.clear();
        let near = level.iter().flat_map(|t| adjacency.neighbours(t)).filter(|&&t| !known.contains(t));
        near.for_each(|&t| next.insert(t));
        // A level is computed from the levels before it alone.
        for t in next.iter() {
            let near = adjacency.neighbours(t).iter().copied().filter(|&n| known.contains(n));
            materials[t.index()] = mean_of(near, materials);
        }
        known.union(&next);
        std::mem::swap(&mut level, &mut next);
    }
    for t in TriangleId::all(materials.len()).filter(|&t| !known.contains(t)) {
        materials[t.index()] = mean;
    }
    Sources { observed, known, any }
}

impl Sources {
    /// The source of a triangle's material.
    pub(crate) fn of(&self, t: TriangleId) -> Filled {
        match (self.observed.contains(t), self.known.contains(t)) {
            (true, _) => Filled::Observed,
            (false, true) => Filled::Neighbours,
            (false, false) if self.any => Filled::SceneMean,
            (false, false) => Filled::Nothing,
        }
    }
}

fn mean_of(triangles: impl Iterator<Item = TriangleId>, materials: &[[f32; Material::LEN]]) -> [f32; Material::LEN] {
    let (mut sum, mut count) = ([0f64; Material::LEN], 0u32);
    for t in triangles {
        sum.iter_mut().zip(materials[t.index()]).for_each(|(s, v)| *s += f64::from(v));
        count += 1;
    }
    sum.map(|s| to_f32(s / f64::from(count)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::Mesh;
    use glam::DVec3;

    /// A strip of `n` triangles, each touching the next, and one triangle far away.
    fn strip(n: u32) -> Mesh {
        let mut v: Vec<DVec3> = (0..n + 2).map(|i| DVec3::new(f64::from(i / 2), f64::from(i % 2), 0.0)).collect();
        let mut f: Vec<[u32; 3]> = (0..n).map(|i| [i, i + 1, i + 2]).collect();
        let end = v.len() as u32;
        v.extend([DVec3::splat(100.0), DVec3::splat(101.0), DVec3::new(100.0, 101.0, 100.0)]);
        f.push([end, end + 1, end + 2]);
        Mesh::new(&v, f).unwrap()
    }

    fn run(n: u32, seen: &[(usize, f32)]) -> (Vec<f32>, Vec<Filled>) {
        let mut materials = vec![[f32::NAN; 7]; n as usize + 1];
        let mut observed = Bits::new(materials.len());
        for &(t, value) in seen {
            materials[t] = [value; 7];
            observed.insert(TriangleId::at(t));
        }
        let sources = fill(&Adjacency::of(&strip(n)), &mut materials, observed);
        (materials.iter().map(|m| m[0]).collect(), (0..=n).map(|t| sources.of(TriangleId(t))).collect())
    }

    #[test]
    fn nearest_observed_wins_and_a_tie_is_the_mean() {
        use Filled::*;
        let (values, filled) = run(5, &[(0, 0.2), (4, 0.6)]);
        assert_eq!(values[..2], [0.2, 0.2]);
        assert!((values[2] - 0.4).abs() < 1e-6);
        assert_eq!(values[3], 0.6);
        assert!((values[5] - 0.4).abs() < 1e-6, "the lone triangle takes the scene's mean");
        assert_eq!(filled, [Observed, Neighbours, Neighbours, Neighbours, Observed, SceneMean]);
    }

    #[test]
    fn nothing_observed_stays_nothing() {
        let (values, filled) = run(3, &[]);
        assert!(values.iter().all(|v| v.is_nan()) && filled.iter().all(|f| *f == Filled::Nothing));
    }
}
