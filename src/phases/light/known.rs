//! The light of a scene, set or found.

use glam::Vec3;

use super::frozen::FrozenLight;
use crate::pipeline::Pipeline;
use crate::stages::light::Mode;
use crate::stages::scene_light::SunAndSky;

/// The light, as far as it is known by now; `frozen` is what was found.
pub(crate) fn light_of(pipeline: &Pipeline, frozen: Option<&FrozenLight>) -> Option<SunAndSky> {
    match pipeline.light.mode {
        Mode::Known => pipeline.light.known(),
        Mode::Estimate | Mode::Ephemeris => frozen?.state().light.as_ref()?.sun_and_sky(),
        Mode::Unknown => None,
    }
}

/// The direction of the sun, as far as it is known by now that one shines.
pub(crate) fn sun_of(pipeline: &Pipeline, frozen: &FrozenLight) -> Option<Vec3> {
    let light = light_of(pipeline, Some(frozen))?;
    (light.sun.color != Vec3::ZERO).then_some(light.sun.direction)
}
