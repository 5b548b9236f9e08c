//! What is finer than a triangle: stains, slabs, tiles, tufts, and wet patches on roads.

use glam::Vec3;

use super::noise::{cell, noise, unit};
use crate::scene::Material;
use crate::synth::city::finish::Substance;

/// Length over which roads are wet or dry, metres.
const PUDDLES: f32 = 5.0;

/// The material at a point of the world, metres, of a surface with this one on average.
pub(super) fn at(substance: Substance, base: &Material, point: Vec3) -> Material {
    let shade = shade(substance, point).max(0.1);
    let m = Material { kd: base.kd.map(|v| (v * shade).min(0.9)), ..*base };
    if substance == Substance::Asphalt { wet(m, point) } else { m }
}

/// The mean material of a triangle with these corners; no number where no such material is.
pub(in crate::synth::city) fn mean(substance: Substance, base: &Material, [a, b, c]: [Vec3; 3]) -> Material {
    const STEPS: usize = 6;
    if substance.is_clear() {
        return Material::from([f32::NAN; Material::LEN]);
    }
    let (mut sum, mut count) = ([0.0; Material::LEN], 0.0);
    for i in 0..STEPS {
        for j in 0..STEPS - i {
            let share = |k: usize| (k as f32 + 1.0 / 3.0) / STEPS as f32;
            let one = at(substance, base, a + (b - a) * share(i) + (c - a) * share(j)).to_array();
            sum.iter_mut().zip(one).for_each(|(sum, v)| *sum += v);
            count += 1.0;
        }
    }
    Material::from(sum.map(|v| v / count))
}

/// How bright a surface is at a point, on average 1.
fn shade(substance: Substance, p: Vec3) -> f32 {
    let at = |metres: f32, purpose: u32| noise(p / metres, purpose);
    let of_cell = |size: Vec3, purpose: u32| 2.0 * unit(cell(p / size), purpose) - 1.0;
    match substance {
        Substance::Asphalt => 1.0 + 0.2 * at(3.0, 1) + 0.15 * at(0.6, 2) + 0.15 * at(0.15, 3),
        Substance::Paving => 1.0 + 0.12 * at(2.0, 4) + 0.15 * of_cell(Vec3::new(0.5, 0.5, 50.0), 5),
        Substance::Gravel => 1.0 + 0.2 * at(1.5, 6) + 0.35 * at(0.2, 7),
        Substance::Grass => 1.0 + 0.3 * at(2.5, 8) + 0.4 * at(0.3, 9),
        Substance::Crop => 1.0 + 0.25 * at(4.0, 10) + 0.3 * at(0.4, 11),
        Substance::Tiles => 1.0 + 0.15 * at(1.5, 12) + 0.22 * of_cell(Vec3::new(0.33, 0.33, 0.25), 13),
        Substance::Sheet => 1.0 + 0.12 * at(2.0, 14) + 0.06 * of_cell(Vec3::splat(0.6), 15),
        Substance::FlatRoof => 1.0 + 0.25 * at(1.5, 16) + 0.12 * at(0.25, 17),
        Substance::Paint => 1.0 + 0.12 * at(1.2, 18) + 0.05 * at(0.3, 19),
        Substance::Brick => 1.0 + 0.25 * of_cell(Vec3::new(0.25, 0.25, 0.08), 20),
        Substance::Stone => 1.0 + 0.2 * at(0.8, 21) + 0.12 * at(0.2, 22),
        Substance::Leaves | Substance::Needles => 1.0 + 0.5 * at(0.25, 23),
        _ => 1.0,
    }
}

/// The same material, darker and shining where the road is wet.
fn wet(dry: Material, p: Vec3) -> Material {
    let share = ((noise(Vec3::new(p.x, p.y, 0.0) / PUDDLES, 24) - 0.25) / 0.2).clamp(0.0, 1.0);
    let towards = |from: f32, to: f32| from + (to - from) * share;
    let kd = dry.kd.map(|v| v * towards(1.0, 0.5));
    Material { kd, ks: dry.ks.map(|v| towards(v, 0.95)), r: towards(dry.r, 0.22) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_mean_of_a_texture_is_the_mean_of_its_points() {
        let base = Material { kd: [0.2, 0.3, 0.1], ks: [0.3; 3], r: 0.8 };
        let corners = [Vec3::new(3.0, 1.0, 0.0), Vec3::new(5.0, 1.5, 0.1), Vec3::new(3.5, 3.0, 0.0)];
        for substance in [Substance::Grass, Substance::Asphalt, Substance::Door] {
            let mut sum = 0.0;
            for i in 0..200 {
                for j in 0..200 {
                    let (mut u, mut v) = ((i as f32 + 0.5) / 200.0, (j as f32 + 0.5) / 200.0);
                    if u + v > 1.0 {
                        (u, v) = (1.0 - u, 1.0 - v);
                    }
                    let [a, b, c] = corners;
                    sum += at(substance, &base, a + (b - a) * u + (c - a) * v).kd[1] / 4e4;
                }
            }
            let mean = mean(substance, &base, corners);
            assert!((mean.kd[1] / sum - 1.0).abs() < 0.06, "{substance:?}: {} {sum}", mean.kd[1]);
        }
        assert!(mean(Substance::Glass, &base, corners).kd[0].is_nan());
    }
}
