//! How well does a light explain what was seen: how much do the albedos of like patches differ under it?

use std::f32::consts::FRAC_1_SQRT_2;

use glam::Vec3A;

use super::blocks::{BLOCKS, Sums};
use super::likeness::Scales;
use super::pairs::Pair;
use super::patches::{Patch, Patches};

/// The light that other surfaces send, relative to the sky's, where it is not known: a tenth, from the ground.
const GROUND: f32 = 0.1;

/// The least ambient light of a patch.
const LEAST: f32 = 0.02;

/// What surfaces reflect of a white sky besides their albedo, by their gloss.
const GLOSS: f32 = 0.008;

/// What shows of lit surfaces in shaded ones, by mixed pixels and glare, in units of a white surface that faces the sun.
const LEAK: f32 = 0.002;

/// The share of a patch's radiance that is albedo's at least.
const LEFT: f32 = 0.3;

/// Radiance that is added before logarithms are taken, in the same units.
const DIM: f32 = 0.003;

/// Patches, their pairs, and what their albedos are compared by.
#[derive(Debug, Clone)]
pub(super) struct Comparison<'a> {
    /// The patches.
    pub patches: &'a Patches<'a>,
    /// The scales of differences between like patches.
    pub scales: Scales,
    /// The radiance of a white surface that faces the sun.
    pub white: f32,
    /// The radiance of other surfaces, which a patch sees where it sees no sky; 0 where it is left out.
    pub bounce: [f32; 3],
    /// The share of the sky's light that reaches each patch.
    ambient: Vec<f32>,
}

impl<'a> Comparison<'a> {
    /// A comparison with scales to begin with, in photographs where white is 1.
    pub(super) fn new(patches: &'a Patches<'a>) -> Self {
        let ambient = |patch: &Patch| (patch.sky + GROUND * (1.0 - patch.sky)).max(LEAST);
        let ambient = patches.all.iter().map(ambient).collect();
        Comparison { patches, scales: Scales::FIRST, white: 1.0, bounce: [0.0; 3], ambient }
    }

    /// The same, with the light that surfaces of this radiance send each other.
    pub(super) fn with_bounce(&self, bounce: [f32; 3]) -> Self {
        let ambient = self.patches.all.iter().map(|patch| patch.sky.max(LEAST)).collect();
        Comparison { bounce, ambient, ..self.clone() }
    }

    /// A comparison of some of the patches, otherwise like another.
    pub(super) fn of(patches: &'a Patches<'a>, other: &Comparison<'_>) -> Self {
        let plain = Comparison { scales: other.scales, white: other.white, ..Comparison::new(patches) };
        if other.bounce == [0.0; 3] { plain } else { plain.with_bounce(other.bounce) }
    }

    /// The log albedo of each patch, turned to brightness and two axes of colour, where `lit` is the sun's cosine times its
    /// share and `ratio` the sky's radiance by the sun's, per channel.
    fn albedos(&self, lit: &[f32], ratio: [f32; 3]) -> Vec<Vec3A> {
        let log = |albedo: [f32; 3]| turned(Vec3A::from_array(albedo.map(f32::ln)));
        lit.iter().enumerate().map(|(at, lit)| log(self.albedo(at, *lit, ratio))).collect()
    }

    /// The albedo of a patch.
    pub(super) fn albedo(&self, at: usize, lit: f32, ratio: [f32; 3]) -> [f32; 3] {
        let (Patch { radiance, sky, .. }, ambient) = (&self.patches.all[at], self.ambient[at]);
        std::array::from_fn(|c| {
            let bounced = self.bounce[c] / self.white * (1.0 - sky);
            albedo(radiance[c], ambient, lit + bounced, ratio[c], self.white)
        })
    }

    /// The squared differences of each pair: of brightness, and of colour.
    pub(super) fn squares(&self, lit: &[f32], ratio: [f32; 3], pairs: &[Pair]) -> Vec<[f32; 2]> {
        let albedos = self.albedos(lit, ratio);
        pairs.iter().map(|pair| difference(&albedos, pair)).collect()
    }

    /// The cost of a light over some pairs: lower is likelier.
    pub(super) fn cost(&self, lit: &[f32], ratio: [f32; 3], pairs: &[Pair]) -> f64 {
        let albedos = self.albedos(lit, ratio);
        self.scales.cost(pairs.iter().map(|pair| difference(&albedos, pair)))
    }

    /// The cost of a light over some pairs, summed block by block.
    pub(super) fn block_costs(&self, lit: &[f32], ratio: [f32; 3], pairs: &[Pair], blocks: &[usize]) -> Sums {
        let mut sums = [0.0; BLOCKS];
        for (square, &block) in self.squares(lit, ratio, pairs).into_iter().zip(blocks) {
            sums[block] += self.scales.cost(std::iter::once(square));
        }
        sums
    }

    /// Makes the scales the likeliest under a light. Returns its cost.
    pub(super) fn fit_scales(&mut self, lit: &[f32], ratio: [f32; 3], pairs: &[Pair]) -> f64 {
        let (scales, cost) = self.scales.fitted(&self.squares(lit, ratio, pairs));
        self.scales = scales;
        cost
    }
}

/// The albedo of one channel, from the radiance of which what gloss and leaks add is taken off.
fn albedo(radiance: f32, ambient: f32, lit: f32, ratio: f32, white: f32) -> f32 {
    let sky = ratio * ambient;
    let own = (radiance - white * (GLOSS * sky + LEAK)).max(LEFT * radiance) + white * DIM;
    own / (white * (lit + sky))
}

/// Log rgb turned to brightness and two axes of colour.
fn turned(log: Vec3A) -> Vec3A {
    const BRIGHTNESS: Vec3A = Vec3A::splat(0.577_350_3);
    const RED_GREEN: Vec3A = Vec3A::new(FRAC_1_SQRT_2, -FRAC_1_SQRT_2, 0.0);
    const YELLOW_BLUE: Vec3A = Vec3A::new(0.408_248_3, 0.408_248_3, -0.816_496_6);
    Vec3A::new(log.dot(BRIGHTNESS), log.dot(RED_GREEN), log.dot(YELLOW_BLUE))
}

fn difference(albedos: &[Vec3A], [i, j]: &Pair) -> [f32; 2] {
    let d = albedos[*i as usize] - albedos[*j as usize];
    [d.x * d.x, d.y * d.y + d.z * d.z]
}
