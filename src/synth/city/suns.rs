//! The light that photographs are taken in: one sun, or several that share out the flight in its order. Where there are several,
//! a photograph tells when it was taken: frames follow each other by seconds, suns by hours. The clock tells suns apart and no
//! more: no place has them there and then.

use glam::{DVec3, Vec3};

use super::CityConfig;
use crate::base::convert::to_usize;
use crate::render::Lighting;
use crate::scene::light::Sun;
use crate::scene::moment::Moment;

/// The radiance seen beyond the fields.
const HAZE: Vec3 = Vec3::new(0.45, 0.52, 0.6);

/// Seconds from a photograph to the next.
const APART: i64 = 4;

/// Seconds from a sun to the next.
const HOURS: i64 = 3 * 3600;

/// The light under each sun, as if every triangle saw the whole sky.
pub(super) fn lights(config: &CityConfig) -> Vec<Lighting> {
    let one = [[config.sun_elevation_deg, config.sun_azimuth_deg]];
    let suns = if config.suns.is_empty() { &one } else { &config.suns[..] };
    suns.iter().map(|&sun| lighting(sun, config.sky)).collect()
}

fn lighting([elevation, azimuth]: [f64; 2], sky: [f32; 3]) -> Lighting {
    let (azimuth, elevation) = (azimuth.to_radians(), elevation.to_radians());
    let direction = DVec3::new(azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin());
    let sun = Sun { direction: direction.as_vec3().normalize(), color: Vec3::ONE };
    Lighting { background: HAZE, ..Lighting::new(sun, Vec3::from(sky)) }
}

/// The sun of the `k`-th photograph, by its place among the [`lights`].
pub(super) fn of_frame(config: &CityConfig, k: usize) -> usize {
    let frames = to_usize(config.frames.into());
    k.min(frames.saturating_sub(1)) * config.suns.len().max(1) / frames.max(1)
}

/// When the `k`-th photograph was taken, where photographs tell.
pub(super) fn taken(config: &CityConfig, k: usize) -> Option<Moment> {
    let morning = Moment::new([2024, 6, 21], [9, 0, 0], None).filter(|_| !config.suns.is_empty())?;
    let since = |n: usize| i64::try_from(n).unwrap_or(i64::MAX);
    Some(Moment { clock: morning.clock + HOURS * since(of_frame(config, k)) + APART * since(k), ..morning })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn suns_share_out_the_flight_in_its_order() {
        let suns = vec![[40.0, 0.0], [30.0, 90.0], [20.0, 180.0]];
        let config = CityConfig { frames: 7, suns, ..CityConfig::default() };
        let shared: Vec<usize> = (0..7).map(|k| of_frame(&config, k)).collect();
        assert_eq!(shared, [0, 0, 0, 1, 1, 2, 2]);
        let directions: Vec<Vec3> = lights(&config).iter().map(|light| light.sun.direction).collect();
        assert!(directions[1].distance(Vec3::new(0.0, 0.866_025_4, 0.5)) < 1e-6, "{directions:?}");
        let times: Vec<String> = [0, 2, 3].iter().map(|&k| taken(&config, k).unwrap().to_string()).collect();
        assert_eq!(times, ["2024-06-21T09:00:00", "2024-06-21T09:00:08", "2024-06-21T12:00:12"]);
        let one = CityConfig { suns: Vec::new(), ..config };
        assert_eq!((lights(&one).len(), of_frame(&one, 6), taken(&one, 6)), (1, 0, None));
    }
}
