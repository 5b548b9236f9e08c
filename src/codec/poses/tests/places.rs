//! Where on the earth frames stand, as formats say it.

use glam::DVec3;

use super::writers::WRITTEN;
use super::{Listed, read, scene};

/// What a format says of its files, in one of which a text was replaced.
fn told(name: &str, [from, to]: [&str; 2]) -> Option<String> {
    let written = WRITTEN.iter().find(|written| written.name == name).unwrap();
    let frames = scene(written.says);
    let mut files = (written.write)(&frames);
    for bytes in files.values_mut() {
        *bytes = String::from_utf8_lossy(bytes).replace(from, to).into_bytes();
    }
    let posed = read(written.format, &files, &Listed::of(&frames)).unwrap();
    posed.georeference.map(|place| place.to_string())
}

#[test]
fn opendronemap_names_zone_and_offset() {
    let offset = DVec3::new(482_706.698_847_3, 1_557_461.395_505_8, 0.0);
    let wanted = format!("EPSG:32616 minus the offset {} {} 0", offset.x, offset.y);
    assert_eq!(told("opendronemap", ["", ""]).as_deref(), Some(&*wanted));
    let unnamed = told("opendronemap", ["WGS84 UTM 16N", "somewhere"]);
    assert!(unnamed.unwrap().starts_with("a system that is not named minus the offset 482706.6"));
}

#[test]
fn metashape_is_geocentric_where_its_chunk_is_georeferenced() {
    let reference =
        |words: &str| told("metashape", ["</cameras>", &format!("</cameras><reference>{words}</reference>")]);
    let wgs84 = "GEOGCS[&quot;WGS 84&quot;,DATUM[&quot;World Geodetic System 1984&quot;]]";
    assert_eq!(reference(wgs84).as_deref(), Some("EPSG:4978"));
    assert_eq!(reference("LOCAL_CS[&quot;Local Coordinates (m)&quot;]"), None);
    assert_eq!(reference("GEOGCS[&quot;Pulkovo 1942&quot;]"), None);
    assert_eq!(told("metashape", ["", ""]), None);
}

#[test]
fn blocks_name_the_system_of_their_coordinates() {
    let of = |systems: &str, id: &str| {
        let systems = format!("<SpatialReferenceSystems>{systems}</SpatialReferenceSystems><Block><SRSId>{id}</SRSId>");
        told("blocks_exchange", ["<Block>", &systems])
    };
    let srs = |id: u32, definition: &str| {
        format!("<SRS><Id>{id}</Id><Name>n</Name><Definition>{definition}</Definition></SRS>")
    };
    let both = srs(0, "LOCAL_CS[&quot;Local&quot;]") + &srs(1, "EPSG:32633+5773");
    assert_eq!(of(&both, "1").as_deref(), Some("EPSG:32633"));
    assert_eq!((of(&both, "0"), of(&both, "2"), told("blocks_exchange", ["", ""])), (None, None, None));
    assert_eq!(of(&srs(7, "ENU:52.125,13.5"), "7").as_deref(), Some("ENU:52.125,13.5"));
    let text = "PROJCS[&quot;RGF93&quot;,AUTHORITY[&quot;EPSG&quot;,&quot;2154&quot;]]";
    assert_eq!(of(&srs(3, text), "3").as_deref(), Some("EPSG:2154"));
    assert_eq!(of(&srs(3, "PROJCS[&quot;somewhere&quot;]"), "3"), None);
}
