//! Materials for triangles that have too little evidence of their own: those of the nearest observed triangles across
//! edges, level by level outwards, so that the result depends on the mesh alone.

use crate::base::ids::TriangleId;
use crate::scene::Material;
use crate::scene::adjacency::Adjacency;
use crate::scene::evidence::{Evidence, Filled};

/// Fills every material that is not [`Filled::Observed`] and marks where it comes from. A triangle takes the mean of
/// its neighbours one level nearer to what was observed; what hangs together with nothing observed takes the mean of
/// all observed triangles. Without any observation nothing changes.
pub fn fill(adjacency: &Adjacency, materials: &mut [[f32; Material::LEN]], evidence: &mut [Evidence]) {
    let observed = |e: &[Evidence], t: usize| e[t].filled == Filled::Observed;
    let mut level: Vec<TriangleId> =
        (0..materials.len()).filter(|&t| observed(evidence, t)).map(|t| t as TriangleId).collect();
    if level.is_empty() {
        return;
    }
    let mean = mean_of(&level, materials);
    let mut known: Vec<bool> = (0..materials.len()).map(|t| observed(evidence, t)).collect();
    while !level.is_empty() {
        let mut next: Vec<TriangleId> =
            level.iter().flat_map(|&t| adjacency.neighbours(t)).copied().filter(|&t| !known[t as usize]).collect();
        next.sort_unstable();
        next.dedup();
        // All of a level are computed from the levels before it, then become known together.
        let values: Vec<_> = next
            .iter()
            .map(|&t| {
                let near = adjacency.neighbours(t).iter().copied().filter(|&n| known[n as usize]);
                mean_of(&near.collect::<Vec<_>>(), materials)
            })
            .collect();
        for (&t, value) in next.iter().zip(values) {
            let t = t as usize;
            (materials[t], evidence[t].filled, known[t]) = (value, Filled::Neighbours, true);
        }
        level = next;
    }
    for t in (0..materials.len()).filter(|&t| !known[t]) {
        (materials[t], evidence[t].filled) = (mean, Filled::SceneMean);
    }
}

fn mean_of(triangles: &[TriangleId], materials: &[[f32; Material::LEN]]) -> [f32; Material::LEN] {
    let mut sum = [0f64; Material::LEN];
    for &t in triangles {
        sum.iter_mut().zip(materials[t as usize]).for_each(|(s, v)| *s += f64::from(v));
    }
    sum.map(|s| (s / triangles.len() as f64) as f32)
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
        let mut evidence = vec![Evidence { filled: Filled::Nothing, ..Evidence::default() }; n as usize + 1];
        for &(t, value) in seen {
            (materials[t], evidence[t].filled) = ([value; 7], Filled::Observed);
        }
        fill(&Adjacency::of(&strip(n)), &mut materials, &mut evidence);
        (materials.iter().map(|m| m[0]).collect(), evidence.iter().map(|e| e.filled).collect())
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
