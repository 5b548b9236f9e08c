//! Where on the earth a scene lies: the coordinate reference system of its coordinates, and what is added to them.

use std::fmt;
use std::str::FromStr;

use glam::DVec3;
use serde::{Deserialize, Serialize};

use crate::base::convert::Cut;

/// A coordinate reference system: one of the EPSG register, or a plane that touches the earth at a place.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Serialize, Deserialize)]
#[serde(into = "String", try_from = "String")]
pub struct Crs(System);

#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum System {
    /// By its number.
    Epsg(u32),
    /// East, north and up in metres from a place, as photogrammetry programs make it where nobody names a system.
    Plane { latitude: Angle, longitude: Angle },
}

/// Billionths of a degree: an angle that may be compared, a tenth of a millimetre on the earth.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
struct Angle(i64);

impl Angle {
    const PARTS: f64 = 1e9;

    /// The angle of a text in degrees, at most so many.
    fn of(text: &str, most: f64) -> Option<Angle> {
        let degrees: f64 = text.trim().parse().ok().filter(|degrees: &f64| degrees.abs() <= most)?;
        Some(Angle(i64::cut((degrees * Angle::PARTS).round())))
    }
}

impl fmt::Display for Angle {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        (self.0 as f64 / Angle::PARTS).fmt(f)
    }
}

/// Which coordinates a system has.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
enum Kind {
    /// UTM: east and north in metres, from the south pole's side where `south`.
    Utm { south: bool },
    /// East and north on a plane, and height.
    Projected,
    /// X, Y and Z in metres from the centre of the earth.
    Geocentric,
    /// Degrees.
    Geographic,
    /// Not known here.
    Other,
}

/// The lengths of the half axes of the earth, metres (WGS 84).
const HALF_AXES: DVec3 = DVec3::new(6_378_137.0, 6_378_137.0, 6_356_752.314_2);

/// Steps of a component of the way up over the curved earth: so it stays where it is though the scene's middle moves by metres.
const STEPS: f64 = 4096.0;

impl Crs {
    /// The geocentric system of WGS 84.
    pub const GEOCENTRIC: Crs = Crs(System::Epsg(4978));

    /// The system of this number, if it may be one.
    pub fn epsg(number: u32) -> Option<Crs> {
        (1024..=32_767).contains(&number).then_some(Crs(System::Epsg(number)))
    }

    /// The plane that a definition names, as "ENU:52.1,13.2": latitude and longitude.
    fn of_plane(text: &str) -> Option<Crs> {
        let place = text.trim();
        let place = place.get(..4).filter(|start| start.eq_ignore_ascii_case("ENU:")).map(|_| &place[4..])?;
        let (latitude, longitude) = place.split_once(',')?;
        let (latitude, longitude) = (Angle::of(latitude, 90.0)?, Angle::of(longitude, 360.0)?);
        Some(Crs(System::Plane { latitude, longitude }))
    }

    /// Whether its coordinates are degrees, which no mesh has.
    pub fn is_geographic(self) -> bool {
        self.kind() == Kind::Geographic
    }

    /// Ranges of numbers of which all systems are of a kind; what lies between is not told.
    fn kind(self) -> Kind {
        let System::Epsg(number) = self.0 else { return Kind::Projected };
        match number {
            32_601..=32_660 | 25_828..=25_838 | 26_901..=26_923 => Kind::Utm { south: false },
            32_701..=32_760 => Kind::Utm { south: true },
            // Axes that point south and west.
            2046..=2055 | 22_275..=22_293 | 29_371..=29_385 => Kind::Other,
            2000..=3817 | 3857 | 20_004..=32_766 => Kind::Projected,
            4978 | 4936 => Kind::Geocentric,
            4326 | 4979 | 4258 | 4937 | 4269 => Kind::Geographic,
            _ => Kind::Other,
        }
    }

    /// The system that a name of UTM names, as "WGS 84 / UTM zone 33N", "WGS84 UTM 33N" or "WGS_1984_UTM_Zone_33N".
    fn of_utm(name: &str) -> Option<Crs> {
        let name: String = name.chars().filter(char::is_ascii_alphanumeric).collect::<String>().to_ascii_uppercase();
        let (datum, zone) = name.split_once("UTM")?;
        let zone = zone.strip_prefix("ZONE").unwrap_or(zone);
        let (zone, south) =
            zone.strip_suffix('N').map(|zone| (zone, false)).or(zone.strip_suffix('S').map(|z| (z, true)))?;
        let zone: u32 = zone.parse().ok().filter(|zone| (1..=60).contains(zone))?;
        match (datum, south) {
            ("" | "WGS84" | "WGS1984", false) => Some(Crs(System::Epsg(32_600 + zone))),
            ("" | "WGS84" | "WGS1984", true) => Some(Crs(System::Epsg(32_700 + zone))),
            ("ETRS89" | "ETRS1989", false) if (28..=38).contains(&zone) => Some(Crs(System::Epsg(25_800 + zone))),
            ("NAD83" | "NAD1983", false) if zone <= 23 => Some(Crs(System::Epsg(26_900 + zone))),
            _ => None,
        }
    }

    /// The system that a definition names: its last authority, its name, or a number.
    pub fn of_definition(text: &str) -> Option<Crs> {
        let authority = text.rsplit_once("AUTHORITY[\"EPSG\",").map(|(_, rest)| rest.trim_start_matches('"'));
        let digits = |rest: &str| rest.chars().take_while(char::is_ascii_digit).collect::<String>().parse().ok();
        let name = text.split('"').nth(1);
        let of_name = || name.and_then(Crs::of_utm).or_else(|| text.trim().parse().ok());
        authority.and_then(digits).and_then(Crs::epsg).or_else(of_name).or_else(|| Crs::of_plane(text))
    }
}

impl FromStr for Crs {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let text = text.trim();
        // A second number is that of the heights.
        let number = text.get(..5).filter(|start| start.eq_ignore_ascii_case("EPSG:")).map_or(text, |_| &text[5..]);
        let number = number.split('+').next().unwrap_or_default().parse().ok();
        let found = number.and_then(Crs::epsg).or_else(|| Crs::of_utm(text)).or_else(|| Crs::of_plane(text));
        found.ok_or_else(|| {
            let rule =
                "must be the number of a system, as \"EPSG:32633\", a zone, as \"UTM 33N\", or a plane at a place, as";
            format!("{rule} \"ENU:52.1,13.2\"")
        })
    }
}

impl From<Crs> for String {
    fn from(crs: Crs) -> String {
        crs.to_string()
    }
}

impl TryFrom<String> for Crs {
    type Error = String;

    fn try_from(text: String) -> Result<Self, String> {
        text.parse()
    }
}

impl fmt::Display for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self.0 {
            System::Epsg(number) => write!(f, "EPSG:{number}"),
            System::Plane { latitude, longitude } => write!(f, "ENU:{latitude},{longitude}"),
        }
    }
}

/// Where on the earth a scene lies.
#[derive(Debug, Clone, Copy, PartialEq, Serialize, Deserialize)]
pub struct Georeference {
    /// The system of the coordinates; `None` where it is not known.
    pub crs: Option<Crs>,
    /// What is added to the scene's coordinates to give coordinates of the system.
    pub offset: [f64; 3],
}

impl Georeference {
    /// A place of the scene in coordinates of the system.
    fn absolute(&self, at: DVec3) -> DVec3 {
        at + DVec3::from(self.offset)
    }

    /// The way up at a place of the scene, if its system tells it.
    pub fn up(&self, at: DVec3) -> Option<DVec3> {
        match self.crs?.kind() {
            Kind::Utm { .. } | Kind::Projected => Some(DVec3::Z),
            Kind::Geocentric => {
                let up = self.absolute(at) / (HALF_AXES * HALF_AXES);
                // Nothing is -0.
                up.try_normalize().map(|up| (up * STEPS).round() / STEPS + DVec3::ZERO)
            }
            Kind::Geographic | Kind::Other => None,
        }
    }

    /// A vector that is north but for what of it is up, if the system tells it.
    pub fn north(&self) -> Option<DVec3> {
        match self.crs?.kind() {
            Kind::Utm { .. } | Kind::Projected => Some(DVec3::Y),
            Kind::Geocentric => Some(DVec3::Z),
            Kind::Geographic | Kind::Other => None,
        }
    }

    /// What is wrong with a place of the scene, in words, if it cannot lie there.
    pub fn doubt(&self, at: DVec3) -> Option<String> {
        let (crs, DVec3 { x, y, z }) = (self.crs?, self.absolute(at));
        let rule = match crs.kind() {
            Kind::Utm { .. } if !((0.0..=1e6).contains(&x) && (0.0..=1e7).contains(&y)) => {
                "has x from 0 to 1000000 and y from 0 to 10000000"
            }
            Kind::Geocentric if !(6.3e6..=6.5e6).contains(&DVec3::new(x, y, z).length()) => {
                "has places about 6370000 from its origin"
            }
            _ => return None,
        };
        Some(format!("{x:.0} {y:.0} {z:.0}, and {crs} {rule}"))
    }
}

impl fmt::Display for Georeference {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let [x, y, z] = self.offset;
        match self.crs {
            Some(crs) => write!(f, "{crs}")?,
            None => f.write_str("a system that is not named")?,
        }
        if self.offset == [0.0; 3] { Ok(()) } else { write!(f, " minus the offset {x} {y} {z}") }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn epsg(number: u32) -> Crs {
        Crs::epsg(number).unwrap()
    }

    fn place(crs: Crs, offset: DVec3) -> Georeference {
        Georeference { crs: Some(crs), offset: offset.to_array() }
    }

    #[test]
    fn systems_are_read_as_programs_write_them() {
        for (text, number) in [
            ("EPSG:32633", 32_633),
            ("epsg:2154", 2154),
            (" 32733 ", 32_733),
            ("EPSG:32633+5773", 32_633),
            ("UTM 33N", 32_633),
            ("WGS84 UTM 16N", 32_616),
            ("WGS 84 / UTM zone 33S", 32_733),
            ("ETRS89 / UTM zone 32N", 25_832),
            ("NAD83 / UTM zone 11N", 26_911),
        ] {
            assert_eq!(text.parse(), Ok(epsg(number)), "{text}");
        }
        for text in
            ["", "EPSG:", "EPSG:x", "12", "99999", "UTM 33", "UTM 61N", "UTM 0S", "Pulkovo / UTM zone 33N", "éééé"]
        {
            assert!(text.parse::<Crs>().is_err_and(|why| why.contains("EPSG:32633")), "{text}");
        }
        for (text, number) in [
            (
                "PROJCS[\"RGF93 / Lambert-93\",GEOGCS[\"RGF93\",AUTHORITY[\"EPSG\",\"4171\"]],AUTHORITY[\"EPSG\",\"2154\"]]",
                2154,
            ),
            ("PROJCS[\"WGS_1984_UTM_Zone_33N\",GEOGCS[\"GCS_WGS_1984\"]]", 32_633),
            ("EPSG:25833\n", 25_833),
        ] {
            assert_eq!(Crs::of_definition(text), Some(epsg(number)), "{text}");
        }
        for text in [
            "LOCAL_CS[\"Local Coordinates (m)\"]",
            "",
            "ENU:52",
            "ENU:91,0",
            "ENU:nan,0",
            "AUTHORITY[\"EPSG\",\"99999999999\"]",
        ] {
            assert_eq!(Crs::of_definition(text), None, "{text}");
        }
    }

    #[test]
    fn up_is_z_on_a_plane_and_away_from_the_centre_of_the_earth() {
        let utm = place(epsg(32_633), DVec3::new(4e5, 5.8e6, 0.0));
        assert_eq!((utm.up(DVec3::ZERO), utm.north()), (Some(DVec3::Z), Some(DVec3::Y)));
        // On the equator, and at 45 degrees of geodetic latitude and 90 degrees east.
        let earth = place(Crs::GEOCENTRIC, DVec3::new(6_378_137.0, 0.0, 0.0));
        assert_eq!((earth.up(DVec3::ONE), earth.north()), (Some(DVec3::X), Some(DVec3::Z)));
        let (up, half) = (DVec3::new(0.0, 1.0, 1.0).normalize(), HALF_AXES);
        let at = half * half * up / (half * up).length();
        assert!(earth.up(at - DVec3::from(earth.offset)).unwrap().angle_between(up).to_degrees() < 0.02);
        assert_eq!(place(Crs::GEOCENTRIC, DVec3::ZERO).up(DVec3::ZERO), None);
        for crs in [2050, 4326, 9999] {
            assert_eq!(
                (place(epsg(crs), DVec3::ONE).up(DVec3::ONE), place(epsg(crs), DVec3::ONE).north()),
                (None, None)
            );
        }
    }

    #[test]
    fn a_plane_at_a_place_has_its_own_up_and_north() {
        for (text, shown) in
            [("ENU:52.123456789,-13.5", "ENU:52.123456789,-13.5"), (" enu:-33, 151.2 ", "ENU:-33,151.2")]
        {
            let plane: Crs = text.parse().unwrap();
            assert_eq!((plane.to_string(), Crs::of_definition(text)), (shown.to_owned(), Some(plane)));
            let place = place(plane, DVec3::ZERO);
            assert_eq!(
                (place.up(DVec3::ONE), place.north(), place.doubt(DVec3::ONE)),
                (Some(DVec3::Z), Some(DVec3::Y), None)
            );
            assert!(!plane.is_geographic());
        }
    }

    #[test]
    fn places_that_cannot_be_there_are_doubted() {
        let local = place(epsg(32_633), DVec3::ZERO);
        assert_eq!(local.doubt(DVec3::new(4e5, 5.8e6, 80.0)), None);
        let doubt = local.doubt(DVec3::new(-12.0, 30.0, 80.0)).unwrap();
        assert_eq!(doubt, "-12 30 80, and EPSG:32633 has x from 0 to 1000000 and y from 0 to 10000000");
        assert_eq!(place(epsg(32_633), DVec3::new(4e5, 5.8e6, 0.0)).doubt(DVec3::new(-12.0, 30.0, 80.0)), None);
        assert!(place(Crs::GEOCENTRIC, DVec3::ZERO).doubt(DVec3::ONE).is_some());
        assert_eq!(place(epsg(2154), DVec3::ZERO).doubt(DVec3::ONE), None);
    }
}
