//! The light under the sun of a place and a time: the photographs tell the sky's part and the scale, decide among zones where the
//! clock's is not known, and may contradict.

use glam::Vec3;

use super::found::{Decided, FoundLight};
use super::occasion::{Occasion, Stand};
use crate::light::ephemeris::{azimuth, elevation, sun_over};
use crate::light::{Clues, Decision, Found, Settings};
use crate::scene::moment::zone_name;

/// Degrees between the sun of the photographs and that of place and time from which on one of them must be wrong.
const APART_DEGREES: f32 = 15.0;

/// Degrees that the sun may move while photographs are taken before that is told.
const MOVES_DEGREES: f64 = 2.0;

/// Finds the light under the sun of an occasion; `None` where it has no sun.
pub(super) fn under(clues: &Clues<'_>, occasion: &Occasion, settings: &Settings) -> Option<FoundLight> {
    let suns: Vec<Vec3> = occasion.suns.iter().map(|stand| stand.sun).collect();
    let costs = if suns.len() > 1 { clues.costs(&suns, settings) } else { vec![0.0] };
    let mut order: Vec<(f64, &Stand)> = costs.into_iter().zip(&occasion.suns).collect();
    order.sort_by(|a, b| a.0.total_cmp(&b.0));
    let (cost, stand) = *order.first()?;
    let alone = clues.find(settings);
    let found = clues.under(stand.sun, settings);
    let (agreement, doubt) = agreement(&alone, stand.sun);
    let seen = format!("{} pairs of {} triangles", found.pairs, found.triangles);
    let decided = match found.decided {
        Decision::TooLittle => format!("{seen} are too few to tell the sky from"),
        Decision::Sun => format!("{seen} fit a sun elsewhere worse by {:.2}", found.turned),
        Decision::Doubtful | Decision::NoSun => {
            format!("{seen} fit a sun elsewhere little worse, by {:.2}", found.turned)
        }
    };
    let zone = order.get(1).filter(|_| occasion.time.zone.is_none()).map(|(next, other)| {
        let [zone, other] = [stand.zone, other.zone].map(zone_name);
        format!("of all zones {zone} fits best, and {other} worse by {:.3}", next - cost)
    });
    let parts = [Some(stands(occasion, stand)), zone, moves(occasion, stand), agreement, Some(decided)];
    let words = parts.into_iter().flatten().collect::<Vec<_>>().join("; ");
    let kept = FoundLight::of(&Found { dome: alone.dome, ..found });
    let decided = if doubt.is_some() && kept.decided == Decided::Sun { Decided::Doubtful } else { kept.decided };
    Some(FoundLight { words, doubt, decided, ..kept })
}

/// Where the sun stands, in words.
fn stands(occasion: &Occasion, stand: &Stand) -> String {
    let [latitude, longitude] = occasion.place;
    let (time, azimuth, elevation) = (occasion.time.in_zone(stand.zone), azimuth(stand.sky), elevation(stand.sky));
    format!(
        "the sun of {time} at latitude {latitude:.3}, longitude {longitude:.3} has azimuth {azimuth:.2} and elevation {elevation:.2}"
    )
}

/// Tells of a sun that moved while the photographs were taken.
fn moves(occasion: &Occasion, stand: &Stand) -> Option<String> {
    let middle = occasion.time.in_zone(stand.zone).utc()?;
    let [first, last] = occasion.ends;
    let apart = |seconds| sun_over(occasion.place, middle + seconds).angle_between(stand.sky).to_degrees();
    let most = apart(first).max(apart(last));
    let hours = (last - first) as f64 / 3600.0;
    (most > MOVES_DEGREES).then(|| {
        format!("the photographs were taken in {hours:.1} hours, in which it moved up to {most:.0} degrees from there")
    })
}

/// What the photographs alone say of the sun, and the same if it contradicts.
fn agreement(alone: &Found, sun: Vec3) -> (Option<String>, Option<String>) {
    let words = match (alone.sun, alone.decided) {
        (_, Decision::TooLittle) => return (None, None),
        (Some(at), Decision::Sun | Decision::Doubtful) => {
            let apart = glam::DVec3::from(at).as_vec3().angle_between(sun).to_degrees();
            if apart <= APART_DEGREES {
                return (Some(format!("the photographs alone put it {apart:.1} degrees from there")), None);
            }
            format!("the photographs alone put it {apart:.0} degrees from there: check place, time, zone, north and up")
        }
        _ => "the photographs alone show no sun: the sky was overcast, most likely, or place, time, zone, north or up is wrong"
            .to_owned(),
    };
    (Some(words.clone()), Some(words))
}
