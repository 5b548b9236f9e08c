//! Where does the sun stand, at a place and a moment?
//!
//! The sun's apparent place is that of J. Meeus, Astronomical Algorithms (1998), chapter 25, "low accuracy", which NOAA's solar
//! calculator uses too: 0.01 degrees from 1950 to 2100. The sphere is turned by the apparent sidereal time (chapter 12). Air lifts
//! the sun by Saemundsson's refraction (chapter 16), as in I. Reda and A. Andreas, Solar Position Algorithm for Solar Radiation
//! Applications (NREL/TP-560-34302, 2008), at 1010 hPa and 10 degrees Celsius. Left out are parallax (0.002 degrees) and the minute by
//! which the clocks of astronomers are ahead (0.001 degrees).

use glam::{DVec3, Vec3};

/// The unit vector towards the sun as it is seen: east, north, up. `place` is latitude, north positive, and longitude, east
/// positive, degrees; `utc` is seconds from noon of 1 January 2000 UTC.
pub(crate) fn sun_over([latitude, longitude]: [f64; 2], utc: i64) -> DVec3 {
    let days = utc as f64 / 86_400.0;
    let centuries = days / 36_525.0;
    let degrees = |constant: f64, a_century: f64| (constant + a_century * centuries).rem_euclid(360.0).to_radians();
    let (mean, anomaly) = (degrees(280.466_46, 36_000.769_83), degrees(357.529_11, 35_999.050_29));
    let (node, tilt) = (degrees(125.04, -1_934.136), degrees(23.439_291_1, -0.013_004_17));
    let centre = (1.914_602 - 0.004_817 * centuries) * anomaly.sin()
        + (0.019_993 - 0.000_101 * centuries) * (2.0 * anomaly).sin()
        + 0.000_289 * (3.0 * anomaly).sin();
    let nutation = -0.004_78 * node.sin();
    let tilt = tilt + (0.002_56 * node.cos()).to_radians();
    let along = mean + (centre - 0.005_69 + nutation).to_radians();
    let equatorial = DVec3::new(along.cos(), tilt.cos() * along.sin(), tilt.sin() * along.sin());
    let sidereal = 280.460_618_37 + 360.985_647_366_29 * days + nutation * tilt.cos() + longitude;
    let (sin, cos) = sidereal.rem_euclid(360.0).to_radians().sin_cos();
    // Towards the meridian, east and the pole.
    let (south, east) = (equatorial.x * cos + equatorial.y * sin, equatorial.y * cos - equatorial.x * sin);
    let (sin, cos) = latitude.to_radians().sin_cos();
    lifted(DVec3::new(east, equatorial.z * cos - south * sin, equatorial.z * sin + south * cos))
}

/// The direction in which air shows a direction. Below the horizon there is nothing to see.
fn lifted(direction: DVec3) -> DVec3 {
    let elevation = elevation(direction);
    if elevation < 0.0 {
        return direction;
    }
    let minutes = 1.02 / (elevation + 10.3 / (elevation + 5.11)).to_radians().tan();
    let (sin, cos) = (elevation + minutes.max(0.0) / 60.0).to_radians().sin_cos();
    (direction.with_z(0.0).normalize_or_zero() * cos).with_z(sin)
}

/// The elevation of an east, north, up direction, degrees.
pub(crate) fn elevation(direction: DVec3) -> f64 {
    direction.z.clamp(-1.0, 1.0).asin().to_degrees()
}

/// The azimuth of an east, north, up direction, degrees from north over east.
pub(crate) fn azimuth(direction: DVec3) -> f64 {
    direction.x.atan2(direction.y).to_degrees().rem_euclid(360.0)
}

/// An east, north, up direction in the coordinates of a mesh with this way up, in which north lies about there. `None` where
/// north and up are one line.
pub(crate) fn in_mesh(direction: DVec3, north: DVec3, up: DVec3) -> Option<Vec3> {
    let up = up.try_normalize()?;
    let north = north.try_normalize()?;
    let level = north - up * up.dot(north);
    // A thousandth: what is left is rounding, or nobody's north.
    let north = (level.length() > 1e-3).then(|| level.normalize())?;
    Some((north.cross(up) * direction.x + north * direction.y + up * direction.z).as_vec3().normalize())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::moment::Moment;

    /// Azimuth and elevation at a place and a moment.
    fn at(place: [f64; 2], date: [i64; 3], time: [i64; 3], zone: i32) -> [f64; 2] {
        let moment = Moment::new(date, time, Some(zone)).and_then(Moment::utc).unwrap();
        let sun = sun_over(place, moment);
        assert!((sun.length() - 1.0).abs() < 1e-12);
        [azimuth(sun), elevation(sun)]
    }

    fn is_near(found: [f64; 2], azimuth: f64, elevation: f64) {
        let off = [(found[0] - azimuth) * elevation.to_radians().cos(), found[1] - elevation];
        assert!(off.iter().all(|off| off.abs() < 0.03), "{found:?} for {azimuth} {elevation}");
    }

    #[test]
    fn the_sun_stands_where_published_tables_have_it() {
        // The example of NREL's report: Golden, Colorado, a zenith angle of 50.11162.
        is_near(at([39.742_476, -105.178_6], [2003, 10, 17], [12, 30, 30], -420), 194.340_24, 90.0 - 50.111_62);
        // A village in Poland in summer.
        is_near(at([52.775, 16.637], [2012, 8, 19], [12, 45, 30], 120), 175.66, 49.73);
    }

    #[test]
    fn the_sky_turns_as_it_does() {
        // At the equinox the sun rises in the east.
        let [azimuth, elevation] = at([0.0, 0.0], [2020, 3, 20], [6, 7, 0], 0);
        assert!((azimuth - 90.0).abs() < 0.1 && elevation.abs() < 1.5, "{azimuth} {elevation}");
        // At the pole it stands as high as it is north of the equator: 23.436 degrees at the June solstice of 2020.
        let [_, elevation] = at([90.0, 0.0], [2020, 6, 20], [21, 44, 0], 0);
        assert!((elevation - 23.436 - 0.038).abs() < 0.01, "{elevation}");
        // South of the tropics noon is north, and midnight below the horizon.
        let [azimuth, elevation] = at([-33.9, 18.4], [2020, 6, 20], [12, 48, 0], 120);
        assert!(!(1.0..=359.0).contains(&azimuth) && (elevation - 32.7).abs() < 0.1, "{azimuth} {elevation}");
        assert!(at([-33.9, 18.4], [2020, 6, 20], [0, 48, 0], 120)[1] < -70.0);
    }

    #[test]
    fn a_mesh_turns_the_sky_with_its_axes() {
        let sun = DVec3::new(0.48, -0.6, 0.64);
        let same = in_mesh(sun, DVec3::Y * 3.0, DVec3::Z * 2.0).unwrap();
        assert!(same.distance(sun.as_vec3()) < 1e-6, "{same}");
        // North along x and up along y: east is along z.
        let turned = in_mesh(sun, DVec3::new(1.0, 5.0, 0.0), DVec3::Y).unwrap();
        assert!(turned.distance(Vec3::new(-0.6, 0.64, 0.48)) < 1e-6, "{turned}");
        assert_eq!(in_mesh(sun, DVec3::Z, DVec3::NEG_Z), None);
        assert_eq!(in_mesh(sun, DVec3::ZERO, DVec3::Z), None);
    }
}
