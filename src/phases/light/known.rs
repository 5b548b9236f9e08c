//! The lights of a scene, set or found, and which frame was taken in which.

use glam::Vec3;

use super::frozen::FrozenLight;
use crate::pipeline::Pipeline;
use crate::stages::light::Mode;
use crate::stages::scene_light::SunAndSky;

/// The lights, as far as they are known by now, that of most frames first; `frozen` is what was found.
pub(crate) fn lights_of(pipeline: &Pipeline, frozen: Option<&FrozenLight>) -> Vec<SunAndSky> {
    match pipeline.light.mode {
        Mode::Known => pipeline.light.known().into_iter().collect(),
        Mode::Estimate | Mode::Ephemeris => {
            let found = frozen.and_then(|frozen| frozen.state().light.as_ref());
            found.map(|light| light.all().filter_map(|light| light.sun_and_sky()).collect()).unwrap_or_default()
        }
        Mode::Unknown => Vec::new(),
    }
}

/// The direction of the sun of each light, as far as it is known by now that one shines.
pub(crate) fn suns_of(pipeline: &Pipeline, frozen: &FrozenLight) -> Vec<Option<Vec3>> {
    let sun = |light: SunAndSky| (light.sun.color != Vec3::ZERO).then_some(light.sun.direction);
    lights_of(pipeline, Some(frozen)).into_iter().map(sun).collect()
}
