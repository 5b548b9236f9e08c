//! The sun of a place and a time: told, read from the photographs, missing, and contradicted.

use exif::Tag;

use super::light::{run, scene_of};
use crate::base::Error;
use crate::codec::images::exif_made::{numbers, said, tell};
use crate::disk::MemStore;
use crate::flow::StopSignal;
use crate::light::ephemeris::sun_over;
use crate::phases::Progress;
use crate::pipeline::load;
use crate::run::{find_light, plan};
use crate::scene::moment::Moment;
use crate::synth::city::CityConfig;

/// A place in Poland, and a moment there.
const PLACE: [f64; 2] = [52.775, 16.637];
const PLACE_SET: &str = "light.place=[52.775,16.637]";
const TIME_SET: &str = "light.time=2012-08-19T12:45:30+02:00";
const EPHEMERIS: &str = "light.mode=ephemeris";

/// Where the sun stood then, east, north, up.
fn sun() -> glam::DVec3 {
    sun_over(PLACE, Moment::new([2012, 8, 19], [12, 45, 30], Some(120)).and_then(Moment::utc).unwrap())
}

/// A city under that sun, by the degrees that synth takes, from x over y.
fn scene() -> tempfile::TempDir {
    let degrees = sun().y.atan2(sun().x).to_degrees().rem_euclid(360.0);
    let elevation = sun().z.asin().to_degrees();
    scene_of(CityConfig { sun_azimuth_deg: degrees, sun_elevation_deg: elevation, ..CityConfig::default() })
}

/// Degrees between a sun and that one.
fn off(sun: Option<[f64; 3]>) -> f64 {
    glam::DVec3::from(sun.expect("there is a sun")).angle_between(self::sun()).to_degrees()
}

#[test]
fn a_place_and_a_time_give_the_sun_and_the_photographs_the_sky() {
    let (dir, store) = (scene(), MemStore::new());
    let (report, notes, told) = run(&dir, &store, &[EPHEMERIS, PLACE_SET, TIME_SET]);
    let (light, told) = (report.light.unwrap(), told.unwrap());
    assert!(off(light.sun) < 0.01, "{light:?}");
    assert!(notes.iter().all(|note| !note.contains("the sun")) && told["decided"] == "sun", "{notes:?} {told}");
    assert!(light.words.contains("azimuth 175.66 and elevation 49.73"), "{}", light.words);
    assert!(report.backend.contains("fit"), "{}", report.backend);
    let sky = CityConfig::default().sky;
    for (found, sky) in light.sky.iter().zip(sky) {
        assert!((*found / sky - 1.0).abs() < 0.25, "{light:?}");
    }
    // A clock of which no zone is known: the photographs decide.
    let (report, notes, _) = run(&dir, &store, &[EPHEMERIS, PLACE_SET, "light.time=2012-08-19T12:45:30"]);
    let light = report.light.unwrap();
    assert!(off(light.sun) < 0.01 && light.words.contains("+02:00 fits best"), "{light:?} {notes:?}");
    // In another hour the sun stood elsewhere, and that is said.
    let (report, notes, told) = run(&dir, &store, &[EPHEMERIS, PLACE_SET, "light.time=2012-08-19T09:45:30+02:00"]);
    let light = report.light.unwrap();
    assert!(off(light.sun) > 30.0 && light.words.contains("the photographs alone put it"), "{light:?}");
    assert!(notes.iter().any(|note| note.contains("check place, time, zone, north and up")), "{notes:?}");
    assert_eq!(told.unwrap()["decided"], "doubtful");
}

#[test]
fn photographs_tell_place_and_time_and_what_is_missing_is_named() {
    let (dir, store) = (scene(), MemStore::new());
    let refused = |sets: &[&str]| {
        let sets: Vec<std::ffi::OsString> = sets.iter().map(std::ffi::OsString::from).collect();
        let pipeline = load(&dir.path().join("p.toml"), &sets).unwrap();
        let (stop, progress) = (StopSignal::new(), Progress::new());
        let why = find_light(&pipeline, false, &stop, &progress).map(drop).unwrap_err();
        assert_eq!(plan(&pipeline).map(drop).unwrap_err().to_string(), why.to_string());
        assert!(matches!(why, Error::Invalid(_)), "{why}");
        why.to_string()
    };
    let both = refused(&[EPHEMERIS]);
    assert!(both.contains("[light] place = [latitude, longitude] and time = \"2014-"), "{both}");
    let time = refused(&[EPHEMERIS, PLACE_SET]);
    assert!(time.contains("when they were taken: set [light] time =") && !time.contains("place ="), "{time}");
    let place = refused(&[EPHEMERIS, TIME_SET]);
    assert!(place.contains("where they were taken: set [light] place =") && !place.contains("time ="), "{place}");
    for frame in 0..8 {
        let image = dir.path().join(format!("images/frame_{frame:03}.jpg"));
        let mut fields = vec![said(Tag::DateTimeOriginal, &format!("2012:08:19 12:{}:30", 41 + frame))];
        fields.extend([numbers(Tag::GPSLatitude, [52.0, 46.5, 0.0]), said(Tag::GPSLatitudeRef, "N")]);
        // One camera knows nothing of where it was.
        if frame > 0 {
            fields.extend([numbers(Tag::GPSLongitude, [16.0, 38.22, 0.0]), said(Tag::GPSLongitudeRef, "E")]);
        }
        tell(&image, &fields);
    }
    let (report, notes, _) = run(&dir, &store, &[EPHEMERIS]);
    let light = report.light.unwrap();
    assert!(off(light.sun) < 0.01 && light.words.contains("2012-08-19T12:45:30+02:00"), "{light:?} {notes:?}");
    let night = refused(&[EPHEMERIS, "light.time=2012-08-19T00:45:30+02:00"]);
    assert!(night.contains("the sun stood 24 degrees below the horizon"), "{night}");
}
