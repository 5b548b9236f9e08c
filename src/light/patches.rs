//! The sampled triangles that the light is found from: where they lie, what light can reach them, and what was seen of them.

use glam::{Vec3, Vec3A};
use rayon::prelude::*;

use super::gains::Gains;
use super::observed::{Sighting, luma};
use crate::base::convert::{Cut, to_f32};
use crate::base::ids::TriangleId;
use crate::scene::Mesh;
use crate::trace::{Bvh, Ray, Shares, visibility};

/// The scene that the sampled triangles are of.
#[derive(Debug, Clone, Copy)]
pub struct Scene<'a> {
    /// The mesh.
    pub mesh: &'a Mesh,
    /// The hierarchy over its triangles.
    pub bvh: &'a Bvh,
    /// Unit vector away from the ground.
    pub up: Vec3,
}

/// Rays that find the share of the sky that a triangle sees.
const SKY_RAYS: u32 = 48;

/// Points of a triangle that rays to the sun leave from. The first is its middle.
pub(super) const POINTS: usize = 4;
const WEIGHTS: [Vec3; POINTS] =
    [Vec3::splat(1.0 / 3.0), Vec3::new(0.7, 0.15, 0.15), Vec3::new(0.15, 0.7, 0.15), Vec3::new(0.15, 0.15, 0.7)];

/// The fewest frames and pixels that see a patch, and its lowest luminance.
const FRAMES: usize = 2;
const PIXELS: u32 = 12;
const DARKEST: f32 = 0.003;

/// One sampled triangle.
#[derive(Debug, Clone, Copy)]
pub(super) struct Patch {
    /// The triangle's position in the sample.
    pub sample: u32,
    /// The unit normal.
    pub normal: Vec3A,
    /// The centroid.
    pub middle: Vec3,
    /// The points that rays leave from, off the surface.
    pub points: [Vec3; POINTS],
    /// The area.
    pub area: f32,
    /// The cosine-weighted share of the sky that it sees.
    pub sky: f32,
    /// The radiance that most frames agree on, gains taken out, linear RGB.
    pub radiance: [f32; 3],
}

/// The patches, neighbours near each other in the list.
#[derive(Debug, Clone)]
pub(super) struct Patches<'a> {
    /// The patches.
    pub all: Vec<Patch>,
    /// Unit vector away from the ground.
    pub up: Vec3,
    /// The distance between neighbours if the patches lay evenly on the mesh.
    pub spacing: f32,
    bvh: &'a Bvh,
}

impl<'a> Patches<'a> {
    /// The patches of a sample that enough was seen of.
    pub(super) fn new(scene: &Scene<'a>, sample: &[TriangleId], sightings: &[Sighting], gains: &Gains) -> Self {
        let mut order: Vec<&Sighting> = sightings
            .iter()
            .filter(|s| (s.sample as usize) < sample.len() && gains.factor(s.frame).is_some())
            .collect();
        order.sort_unstable_by_key(|s| (s.sample, s.frame));
        let shares = Shares::new(scene.mesh, SKY_RAYS);
        let offset = visibility::offset(scene.mesh);
        let groups: Vec<&[&Sighting]> = order.chunk_by(|a, b| a.sample == b.sample).collect();
        let patch = |seen: &&[&Sighting]| {
            let radiance = radiance(seen, gains)?;
            let at = seen.first()?.sample;
            let t = *sample.get(at as usize)?;
            let corners = scene.mesh.corners(t);
            let normal = scene.mesh.normal(t)?;
            let [a, b, c] = corners;
            let points = WEIGHTS.map(|w| a * w.x + b * w.y + c * w.z + normal * offset);
            let area = 0.5 * (b - a).cross(c - a).length();
            let sky = shares.sky(scene.mesh, scene.bvh, scene.up, t);
            Some(Patch { sample: at, normal: normal.into(), middle: (a + b + c) / 3.0, points, area, sky, radiance })
        };
        let mut all: Vec<Patch> = groups.par_iter().filter_map(patch).collect();
        let low = all.iter().fold(Vec3::INFINITY, |low, p| low.min(p.middle));
        let high = all.iter().fold(Vec3::NEG_INFINITY, |high, p| high.max(p.middle));
        let size = (high - low).max_element().max(f32::MIN_POSITIVE);
        all.sort_by_cached_key(|patch| along_curve((patch.middle - low) / size));
        let spacing = (surface(scene.mesh) / all.len().max(1) as f64).sqrt();
        Patches { all, up: scene.up, spacing: to_f32(spacing), bvh: scene.bvh }
    }

    /// At most `count` of the patches, spread over all.
    pub(super) fn thinned(&self, count: usize) -> Self {
        let every = self.all.len().div_ceil(count.max(1)).max(1);
        let all: Vec<Patch> = self.all.iter().copied().step_by(every).collect();
        let wider = (self.all.len() as f32 / all.len().max(1) as f32).sqrt();
        Patches { all, spacing: self.spacing * wider, ..*self }
    }

    /// The cosine of the sun at each patch times the share of it that the sun reaches, found by rays from its first
    /// `points` points.
    pub(super) fn sun(&self, sun: Vec3, points: usize) -> Vec<f32> {
        // Patches lie too far apart for their rays to go together.
        let reached = |patch: &Patch| {
            let cos = patch.normal.dot(sun.into());
            if cos <= 0.0 {
                return 0.0;
            }
            let free = |origin: &&Vec3| !self.bvh.occluded(&Ray { origin: **origin, direction: sun }, f32::INFINITY);
            cos * patch.points[..points].iter().filter(free).count() as f32 / points as f32
        };
        self.all.iter().map(reached).collect()
    }
}

/// The area of a mesh.
fn surface(mesh: &Mesh) -> f64 {
    let area = |t| {
        let [a, b, c] = mesh.corners(t);
        f64::from((b - a).cross(c - a).length())
    };
    0.5 * TriangleId::all(mesh.len()).map(area).sum::<f64>()
}

/// The radiance that most frames agree on: the mean of the median by luminance and its two neighbours. `None` if too little
/// was seen.
fn radiance(seen: &[&Sighting], gains: &Gains) -> Option<[f32; 3]> {
    let pixels = seen.iter().map(|s| s.pixels).fold(0, u32::saturating_add);
    let mut by_luma: Vec<(f32, [f32; 3], f32)> = Vec::with_capacity(seen.len());
    for s in seen.iter().filter(|s| s.pixels > 0) {
        let gain = gains.factor(s.frame)?;
        let rgb = s.mean.map(|v| v / gain);
        let pixels = s.pixels as f32;
        if luma(rgb).is_finite() {
            by_luma.push((luma(rgb), rgb, pixels / (pixels + 10.0)));
        }
    }
    if by_luma.len() < FRAMES || pixels < PIXELS {
        return None;
    }
    by_luma.sort_by(|a, b| a.0.total_cmp(&b.0));
    let half = 0.5 * by_luma.iter().map(|seen| seen.2).sum::<f32>();
    let mut sum = 0.0;
    let middle = by_luma.iter().position(|seen| {
        sum += seen.2;
        sum >= half
    });
    let middle = middle.unwrap_or(0);
    let three = [middle.saturating_sub(1), middle, (middle + 1).min(by_luma.len() - 1)];
    let rgb = std::array::from_fn(|c| three.iter().map(|&i| by_luma[i].1[c].max(0.0)).sum::<f32>() / 3.0);
    (luma(rgb) > DARKEST).then_some(rgb)
}

/// The place of a point of the unit cube along Morton's curve.
fn along_curve(at: Vec3) -> u32 {
    let spread = |v: f32| (0..10).fold(0, |bits, i| bits | (u32::cut(v.clamp(0.0, 1.0) * 1023.0) >> i & 1) << (3 * i));
    spread(at.x) | spread(at.y) << 1 | spread(at.z) << 2
}
