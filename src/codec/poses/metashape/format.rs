//! The format `metashape`: `cameras.xml`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use roxmltree::Node;

use super::frame::Frames;
use super::lens;
use crate::base::shown::{short, shown};
use crate::base::{Error, Result};
use crate::codec::poses::format::{PoseFormat, Posed, Target};
use crate::codec::poses::photographs::Photographs;
use crate::codec::poses::{found, names, whole, xml};
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;
use crate::scene::georeference::{Crs, Georeference};

/// Metashape's cameras.
pub(crate) const METASHAPE: PoseFormat = PoseFormat {
    name: "metashape",
    programs: "Metashape, PhotoScan",
    target: Target::Either,
    advice: "name the cameras.xml that Metashape exports, or the folder that holds it",
    is_at: |path| file(path).is_some_and(|file| is_one(&file)),
    missing: |path| found::missing(path, file(path).is_some(), "must be cameras.xml or hold it"),
    read,
};

fn file(path: &Path) -> Option<PathBuf> {
    let other = || found::told(path, &[".xml"], is_one).filter(|file| is_one(file));
    found::named(path, &["cameras.xml", "camera.xml"]).or_else(other)
}

fn is_one(file: &Path) -> bool {
    let text = whole::start_text(file, 4096);
    text.contains("<document") && text.contains("<chunk")
}

/// A camera that has a pose.
struct Aligned<'a, 'i> {
    node: Node<'a, 'i>,
    label: &'a str,
    sensor: &'a str,
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no cameras.xml is there"))?;
    let text = whole::text(&file)?;
    let document = xml::parse(&file, &text)?;
    let fault = |why: String| Error::malformed(&file, why);
    let with_cameras = |chunk: &Node<'_, '_>| xml::child(*chunk, "cameras").is_some();
    let mut chunks = xml::children(document.root_element(), "chunk").filter(with_cameras);
    let chunk = chunks.next().ok_or_else(|| fault("no <chunk> has <cameras>".to_owned()))?;
    let frames = Frames::of(chunk).map_err(fault)?;
    let sensors = xml::child(chunk, "sensors").into_iter().flat_map(|all| xml::children(all, "sensor"));
    let sensors: BTreeMap<&str, Node<'_, '_>> =
        sensors.map(|sensor| (sensor.attribute("id").unwrap_or_default(), sensor)).collect();
    let Chosen { aligned, unaligned, disabled } = choose(chunk, &sensors).map_err(fault)?;
    let written: Vec<String> = aligned.iter().map(|camera| camera.label.to_owned()).collect();
    let mut made: BTreeMap<&str, Arc<Camera>> = BTreeMap::new();
    let mut all = Vec::with_capacity(aligned.len());
    for (Aligned { node, label, sensor }, name) in aligned.into_iter().zip(names::settled(&written, photographs)?) {
        let fault = |why| fault(format!("camera {}: {why}", shown(label)));
        let camera = match made.get(sensor) {
            Some(camera) => Arc::clone(camera),
            None => {
                let node = sensors.get(sensor);
                let node =
                    node.ok_or_else(|| fault(format!("its sensor {} is not among the sensors", shown(sensor))))?;
                let camera = lens::camera(*node).map_err(|why| fault(format!("its sensor {sensor}: {why}")))?;
                let camera = Arc::new(camera);
                made.insert(sensor, Arc::clone(&camera));
                camera
            }
        };
        let matrix = xml::numbers(node, "transform").map_err(fault)?;
        let pose = frames.pose(node.attribute("component_id"), matrix).map_err(fault)?;
        all.push(Frame { name, camera, pose });
    }
    let mut notes = Vec::new();
    if disabled > 0 {
        notes.push(format!("{disabled} cameras are disabled in Metashape and are left out"));
    }
    if chunks.next().is_some() {
        notes.push("the file has several chunks; the first with cameras is read".to_owned());
    }
    let mut georeference = None;
    if let Some(crs) = xml::text(chunk, "reference").filter(|crs| !crs.starts_with("LOCAL_CS")) {
        let named = short(crs.split('"').nth(1).unwrap_or(crs));
        notes.push(format!("the chunk is georeferenced ({named}): the world is geocentric, X Y Z in metres"));
        // Other ellipsoids have geocentric systems of their own.
        let is_wgs84 = ["WGS 84", "WGS84", "WGS_1984"].iter().any(|name| crs.contains(name));
        georeference = is_wgs84.then_some(Georeference { crs: Some(Crs::GEOCENTRIC), offset: [0.0; 3] });
    }
    Ok(Posed { frames: all, unposed: unaligned, georeference, notes })
}

/// The cameras of a chunk: posed, not aligned, and how many are disabled.
struct Chosen<'a, 'i> {
    aligned: Vec<Aligned<'a, 'i>>,
    unaligned: Vec<String>,
    disabled: usize,
}

fn choose<'a, 'i>(chunk: Node<'a, 'i>, sensors: &BTreeMap<&str, Node<'a, 'i>>) -> Result<Chosen<'a, 'i>, String> {
    let mut chosen = Chosen { aligned: Vec::new(), unaligned: Vec::new(), disabled: 0 };
    // Cameras may stand in groups.
    for node in xml::child(chunk, "cameras").into_iter().flat_map(|all| xml::all(all, "camera")) {
        let (label, sensor) =
            (node.attribute("label").unwrap_or_default(), node.attribute("sensor_id").unwrap_or_default());
        let off = |value: &str| value == "false" || value == "0";
        if sensors.get(sensor).map_or(Ok(0), |sensor| lens::band(*sensor))? > 0 {
            continue;
        }
        if node.attribute("enabled").is_some_and(off) {
            chosen.disabled += 1;
        } else if xml::child(node, "transform").is_none() {
            chosen.unaligned.push(label.to_owned());
        } else {
            chosen.aligned.push(Aligned { node, label, sensor });
        }
    }
    Ok(chosen)
}
