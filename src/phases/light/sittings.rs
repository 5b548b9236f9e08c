//! The lights of several sittings. Each is found from what its own frames saw, with gains of its own. Suns that cannot be told
//! apart are one, and a sitting that tells no light is given to a neighbour. What is left is brought to one scale: the triangles
//! have the same albedo in all lights.

use glam::{DVec3, Vec3};

use super::found::FoundLight;
use crate::light::{Clues, Gains, luma};

/// Suns that are less far apart are one, degrees; so are those that lie within twice their spreads.
const APART_DEGREES: f64 = 2.0;

/// The fewest triangles that tell the scale of a light by another.
const FEWEST: usize = 50;

/// A sitting: its frames' sightings prepared, and the light that was found.
pub(super) struct Sitting<'a> {
    /// What its light was found from.
    pub clues: Clues<'a>,
    /// The gains of its frames; none for the others.
    pub gains: Gains,
    /// The light of its frames.
    pub light: FoundLight,
}

/// The sittings of which one is to be given to the other, if there are any: one without a light, or two of one light.
pub(super) fn alike(lights: &[&FoundLight]) -> Option<(usize, usize)> {
    let pairs = || (0..lights.len()).flat_map(|b| (0..b).map(move |a| (a, b)));
    // Sittings come in the order of time, so that those beside each other are neighbours.
    let dark = lights.iter().position(|light| light.sun_and_sky().is_none()).map(|at| (at.max(1) - 1, at.max(1)));
    let dark = dark.filter(|_| lights.len() > 1);
    dark.or_else(|| pairs().find(|(a, b)| same(lights[*a], lights[*b])))
}

fn same(a: &FoundLight, b: &FoundLight) -> bool {
    match (a.told_sun(), b.told_sun()) {
        (None, None) => true,
        (Some(one), Some(other)) => {
            let apart = DVec3::from(one).angle_between(DVec3::from(other)).to_degrees();
            apart <= APART_DEGREES.max(2.0 * f64::from(a.sun_degrees.hypot(b.sun_degrees)))
        }
        _ => false,
    }
}

/// One light of several sittings, the first of them that of most frames: the others are brought to its scale.
pub(super) fn together(mut sittings: Vec<Sitting<'_>>, counts: &[usize]) -> Option<FoundLight> {
    let albedos = |Sitting { clues, light, .. }: &Sitting<'_>| {
        let sun = light.told_sun().map(|sun| DVec3::from(sun).as_vec3());
        clues.albedos(sun, light.white, light.sky, light.bounce)
    };
    let first = albedos(sittings.first()?);
    for sitting in &mut sittings[1..] {
        let own = albedos(sitting);
        let mut factors = [1.0; 3];
        for (c, factor) in factors.iter_mut().enumerate() {
            let brighter = |(at, albedo): (&u32, &[f32; 3])| Some(albedo[c] / first.get(at)?[c]);
            let mut all: Vec<f32> = own.iter().filter_map(brighter).filter(|f| f.is_finite()).collect();
            all.sort_unstable_by(f32::total_cmp);
            if all.len() >= FEWEST {
                *factor = all[all.len() / 2];
            }
        }
        scale(&mut sitting.light, factors);
    }
    let mut lights = sittings.into_iter().map(|sitting| sitting.light);
    let mut light = lights.next()?;
    light.others = lights.collect();
    let told: Vec<String> =
        light.others.iter().zip(&counts[1..]).map(|(other, count)| other_words(other, *count)).collect();
    if !told.is_empty() {
        light.words = format!("{}; {}", light.words, told.join("; "));
    }
    Some(light)
}

fn scale(light: &mut FoundLight, factors: [f32; 3]) {
    let by = |value: [f32; 3]| (Vec3::from(value) * Vec3::from(factors)).to_array();
    (light.color, light.sky, light.bounce) = (by(light.color), by(light.sky), by(light.bounce));
    light.white *= luma(factors);
}

fn other_words(light: &FoundLight, frames: usize) -> String {
    match light.told_sun() {
        Some([x, y, z]) => {
            format!(
                "{frames} photographs were taken in another light, with the sun at [{x:.3}, {y:.3}, {z:.3}]: {}",
                light.words
            )
        }
        None => format!("{frames} photographs were taken under another sky, without a sun: {}", light.words),
    }
}

#[cfg(test)]
mod tests {
    use super::super::found::Decided;
    use super::*;

    fn light(sun: Option<[f64; 3]>, decided: Decided) -> FoundLight {
        let told = r#"{"sun": null, "color": [1, 1, 1], "sky": [0.2, 0.2, 0.2], "sun_degrees": 0.5, "ratio": [0.1, 0.1, 0.1],
                       "scale": 0.2, "turned": 1, "white": 1, "decided": "sun", "words": "seen", "dome": []}"#;
        FoundLight { sun, decided, ..serde_json::from_str(told).unwrap() }
    }

    fn at(degrees: f64) -> FoundLight {
        light(Some([degrees.to_radians().cos(), 0.0, degrees.to_radians().sin()]), Decided::Sun)
    }

    #[test]
    fn suns_that_cannot_be_told_apart_are_one_and_a_sitting_without_a_light_goes_to_a_neighbour() {
        let of = |lights: &[FoundLight]| alike(&lights.iter().collect::<Vec<_>>());
        assert_eq!(of(&[at(30.0), at(32.5)]), None);
        assert_eq!(of(&[at(30.0), at(40.0), at(31.5)]), Some((0, 2)));
        let unsure = FoundLight { sun_degrees: 3.0, ..at(36.0) };
        assert_eq!(of(&[at(30.0), unsure]), Some((0, 1)), "within their spreads");
        let (cloudy, untold) = (light(None, Decided::NoSun), light(None, Decided::TooLittle));
        assert_eq!(of(&[at(30.0), cloudy.clone()]), None);
        assert_eq!(of(&[cloudy.clone(), at(30.0), cloudy]), Some((0, 2)));
        assert_eq!(of(&[at(30.0), at(60.0), untold.clone()]), Some((1, 2)));
        assert_eq!(of(&[untold.clone(), at(60.0)]), Some((0, 1)));
        assert_eq!(of(&[untold]), None);
    }

    #[test]
    fn another_light_is_brought_to_the_scale_of_the_first_by_channel() {
        let mut found = at(30.0);
        found.bounce = [0.1; 3];
        scale(&mut found, [2.0, 1.0, 0.5]);
        assert_eq!((found.color, found.sky, found.bounce), ([2.0, 1.0, 0.5], [0.4, 0.2, 0.1], [0.2, 0.1, 0.05]));
        assert!((found.white - (2.0 * 0.2126 + 0.7152 + 0.5 * 0.0722)).abs() < 1e-6);
    }
}
