//! When and where the photographs were taken, and where the sun stood then: what the pipeline file says, else the median of what
//! the photographs' EXIF tells.

use glam::{DVec3, Vec3};
use rayon::prelude::*;

use crate::base::convert::to_f32;
use crate::base::{Error, Result};
use crate::codec::images::{Taken, taken};
use crate::light::Gains;
use crate::light::ephemeris::{elevation, in_mesh, sun_over};
use crate::pipeline::Pipeline;
use crate::scene::frame::Frame;
use crate::scene::moment::Moment;

/// When and where the photographs were taken.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Occasion {
    /// Latitude and longitude, degrees.
    pub place: [f64; 2],
    /// The moment; the median over the photographs where they tell it.
    pub time: Moment,
    /// Seconds from that moment to the first and to the last photograph; 0 where the moment is given.
    pub ends: [i64; 2],
    /// The suns that may have shone, by day: one where the clock's zone is known.
    pub suns: Vec<Stand>,
}

/// A sun that may have shone.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Stand {
    /// Minutes that the clock would be ahead of UTC.
    pub zone: i32,
    /// Towards the sun: east, north, up.
    pub sky: DVec3,
    /// Unit vector towards the sun, in the mesh's coordinates.
    pub sun: Vec3,
}

/// Zones of other than whole hours, minutes ahead of UTC.
const ODD_ZONES: [i32; 12] = [-570, -210, -150, 210, 270, 330, 345, 390, 525, 570, 630, 765];

/// How far a clock may be from the place's own time, minutes: no country is further.
const FARTHEST: f64 = 210.0;

impl Occasion {
    /// When and where the photographs of these frames were taken.
    ///
    /// # Errors
    /// Neither the pipeline file nor a photograph tells the place, or the time; the sun was below the horizon; north cannot be
    /// told.
    pub(crate) fn of(pipeline: &Pipeline, frames: &[Frame]) -> Result<Occasion> {
        let given = pipeline.light.place.is_some() && pipeline.light.time.is_some();
        Occasion::told(pipeline, &if given { vec![Taken::default(); frames.len()] } else { all_told(pipeline, frames) })
    }

    /// When and where photographs were taken that tell this.
    ///
    /// # Errors
    /// As for those of frames.
    pub(crate) fn told(pipeline: &Pipeline, told: &[Taken]) -> Result<Occasion> {
        let config = &pipeline.light;
        let place = config.place.or_else(|| middle_place(told));
        let time = config.time.map(|time| (time, [0; 2])).or_else(|| middle_time(told));
        let (Some(place), Some((time, ends))) = (place, time) else {
            return Err(untold(place.is_none(), time.is_none(), told.len()));
        };
        let up = DVec3::from(pipeline.scene.up);
        let wrong = |problem: crate::config::Problem| Error::invalid(format!("[light] north: {}", problem.rule));
        let north = config.north(pipeline.scene.up).map_err(wrong)?;
        let stand = |zone: i32| {
            let sky = sun_over(place, time.in_zone(zone).utc()?);
            Some(Stand { zone, sky, sun: in_mesh(sky, north, up)? })
        };
        let all: Vec<Stand> = zones(time, place[1]).into_iter().filter_map(stand).collect();
        let highest = all.iter().map(|stand| elevation(stand.sky)).fold(f64::NEG_INFINITY, f64::max);
        let suns: Vec<Stand> = all.into_iter().filter(|stand| stand.sky.z > 0.0).collect();
        if suns.is_empty() {
            let [latitude, longitude] = place;
            return Err(Error::invalid(format!(
                "the sun stood {:.0} degrees below the horizon at {time}, latitude {latitude:.3}, longitude {longitude:.3}: set \
                 [light] place and time, or mode = \"estimate\"",
                -highest
            )));
        }
        Ok(Occasion { place, time, ends, suns })
    }
}

/// What the photographs of frames tell. One that cannot be read tells nothing.
pub(super) fn all_told(pipeline: &Pipeline, frames: &[Frame]) -> Vec<Taken> {
    frames.par_iter().map(|frame| taken(&pipeline.scene.images.join(&frame.name)).unwrap_or_default()).collect()
}

/// What to do where something is not told.
fn untold(place: bool, time: bool, frames: usize) -> Error {
    let place_key = "place = [latitude, longitude]";
    let time_key = "time = \"2014-05-26T12:45:30+02:00\"";
    let (what, keys) = match (place, time) {
        (true, true) => ("where and when they were taken", format!("{place_key} and {time_key}")),
        (true, false) => ("where they were taken", place_key.to_owned()),
        _ => ("when they were taken", time_key.to_owned()),
    };
    Error::invalid(format!(
        "[light] mode = \"ephemeris\": none of the {frames} photographs tells in its EXIF {what}: set [light] {keys}, or mode = \
         \"estimate\""
    ))
}

/// The zones that a clock may have had, minutes ahead of UTC.
fn zones(time: Moment, longitude: f64) -> Vec<i32> {
    if let Some(zone) = time.zone {
        return vec![zone];
    }
    let near = |zone: &i32| (f64::from(*zone) - 4.0 * longitude).abs() <= FARTHEST;
    let mut zones: Vec<i32> = (-12..=14).map(|hour| 60 * hour).chain(ODD_ZONES).filter(near).collect();
    zones.sort_unstable();
    zones
}

/// The median of latitudes, and that of longitudes, which are counted from the first of them, since they go round.
pub(crate) fn middle_place(told: &[Taken]) -> Option<[f64; 2]> {
    let places: Vec<[f64; 2]> = told.iter().filter_map(|taken| taken.place).collect();
    let first = places.first()?[1];
    let around = |longitude: f64| (longitude - first + 180.0).rem_euclid(360.0) - 180.0;
    let latitude = middle(places.iter().map(|place| place[0]).collect())?;
    let longitude = first + middle(places.iter().map(|place| around(place[1])).collect())?;
    Some([latitude, (longitude + 180.0).rem_euclid(360.0) - 180.0])
}

fn middle(mut values: Vec<f64>) -> Option<f64> {
    values.sort_by(f64::total_cmp);
    values.get(values.len() / 2).copied()
}

/// The median moment, and seconds from it to the first and the last. Where some photographs tell the zone, those alone count.
pub(crate) fn middle_time(told: &[Taken]) -> Option<(Moment, [i64; 2])> {
    let of = |(taken, seconds): (&Taken, Option<i64>)| Some((seconds?, taken.time?));
    let mut times: Vec<(i64, Moment)> = told.iter().zip(seconds(told)).filter_map(of).collect();
    times.sort_by_key(|(seconds, _)| *seconds);
    let (middle, time) = *times.get(times.len() / 2)?;
    Some((time, [times.first()?.0 - middle, times.last()?.0 - middle]))
}

/// The times that are told, as seconds of one clock. Where some photographs tell the zone, those alone count.
pub(super) fn seconds(told: &[Taken]) -> Vec<Option<i64>> {
    let zoned = told.iter().filter_map(|taken| taken.time).any(|time| time.zone.is_some());
    let of = |time: Moment| (time.zone.is_some() == zoned).then(|| time.utc().unwrap_or(time.clock));
    told.iter().map(|taken| taken.time.and_then(of)).collect()
}

/// The correlation of the logarithms of gains and of the exposures that photographs tell; `None` where fewer than eight tell one,
/// or all the same. Clouds lower it, and so does what is done to photographs before they come here.
pub(super) fn agreement(told: &[Taken], gains: &Gains) -> Option<f32> {
    let of = |(taken, gain): (&Taken, &Option<f32>)| Some([taken.exposure.factor()?.ln(), f64::from((*gain)?)]);
    let both: Vec<[f64; 2]> = told.iter().zip(&gains.log).filter_map(of).collect();
    let count = both.len() as f64;
    let mean = [0, 1].map(|k| both.iter().map(|pair| pair[k]).sum::<f64>() / count);
    let product = |a: usize, b: usize| both.iter().map(|p| (p[a] - mean[a]) * (p[b] - mean[b])).sum::<f64>() / count;
    let (exif, gain) = (product(0, 0), product(1, 1));
    (both.len() >= 8 && exif.sqrt() > 0.05 && gain > 0.0).then(|| to_f32(product(0, 1) / (exif * gain).sqrt()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::codec::images::Exposure;

    fn at(hour: i64, zone: Option<i32>) -> Taken {
        Taken { time: Moment::new([2014, 5, 26], [hour, 0, 0], zone), ..Taken::default() }
    }

    #[test]
    fn the_median_photograph_tells_the_time_and_a_zone_counts_more() {
        let (time, ends) = middle_time(&[at(11, None), at(9, None), at(10, None)]).unwrap();
        assert_eq!((time.to_string().as_str(), ends), ("2014-05-26T10:00:00", [-3600, 3600]));
        // Eleven at two hours ahead is before ten in Greenwich.
        let (time, ends) = middle_time(&[at(7, None), at(11, Some(120)), at(10, Some(0))]).unwrap();
        assert_eq!((time.to_string().as_str(), ends), ("2014-05-26T10:00:00+00:00", [-3600, 0]));
        assert_eq!(middle_time(&[Taken::default()]), None);
    }

    #[test]
    fn the_median_place_may_lie_where_longitudes_meet() {
        let at = |longitude| Taken { place: Some([-17.0, longitude]), ..Taken::default() };
        let [latitude, longitude] = middle_place(&[at(179.9), at(-179.9), at(-179.8)]).unwrap();
        assert!((latitude + 17.0).abs() < 1e-9 && (longitude + 179.9).abs() < 1e-9, "{latitude} {longitude}");
        assert_eq!(middle_place(&[Taken::default()]), None);
    }

    #[test]
    fn gains_are_held_against_the_exposures_that_are_told() {
        let iso = |iso: u32| Taken {
            exposure: Exposure { seconds: Some(0.01), aperture: None, iso: Some(iso) },
            ..Taken::default()
        };
        let told: Vec<Taken> = [100, 200, 400, 800, 100, 200, 400, 800].map(iso).into();
        let gains = |log: &[f32]| Gains { log: log.iter().map(|log| Some(*log)).collect(), residual: 0.0 };
        let twice = [0.1, 0.79, 1.5, 2.2, 0.1, 0.8, 1.49, 2.2];
        assert!(agreement(&told, &gains(&twice)).is_some_and(|r| r > 0.999));
        assert!(agreement(&told, &gains(&twice.map(|log| -log))).is_some_and(|r| r < -0.999));
        assert_eq!(agreement(&told[..7], &gains(&twice)), None, "too few");
        assert_eq!(agreement(&vec![iso(100); 8], &gains(&twice)), None, "all the same");
        assert_eq!(agreement(&vec![Taken::default(); 8], &gains(&twice)), None);
    }

    #[test]
    fn zones_are_those_of_the_place() {
        let noon = Moment::new([2014, 5, 26], [12, 0, 0], None).unwrap();
        assert_eq!(zones(noon, 16.6), [-120, -60, 0, 60, 120, 180, 210, 240, 270]);
        assert!(zones(noon, 77.2).contains(&330) && zones(noon, -179.0).contains(&-720));
        assert_eq!(zones(noon.in_zone(330), 16.6), [330]);
    }
}
