//! BlocksExchange XML of ContextCapture and iTwin Capture, which Metashape and others export too (ContextCapture's manual,
//! "BlocksExchange XML format").
//!
//! - A photogroup has a lens; a photo has a rotation, world-to-camera by rows, and a centre. `CameraOrientation` says which
//!   way the camera's x and y lead; XRightYDown, which is ours, where nothing is said.
//! - `SRSId` of the block names the system of its coordinates, one of `SpatialReferenceSystems`: `EPSG:n`, well-known text, or
//!   `ENU:latitude,longitude` for a plane at a place.
//! - `PrincipalPoint` is in pixels from the corner. P1 and P2 are exchanged against OpenCV's.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DMat3, DVec2, DVec3};
use roxmltree::Node;

use super::format::{PoseFormat, Posed, Target};
use super::photographs::Photographs;
use super::{found, names, posed, terms, whole, xml};
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::scene::camera::{Camera, Distortion, Lens, Projection};
use crate::scene::frame::Frame;
use crate::scene::georeference::{Crs, Georeference};
use crate::scene::pose::Pose;

/// ContextCapture's blocks.
pub(crate) const BLOCKS_EXCHANGE: PoseFormat = PoseFormat {
    name: "blocks_exchange",
    programs: "ContextCapture, iTwin Capture",
    target: Target::Either,
    advice: "name the BlocksExchange .xml file",
    is_at: |path| file(path).is_some_and(|file| is_one(&file)),
    missing: |path| found::missing(path, file(path).is_some(), "must be a BlocksExchange .xml file or hold blocks.xml"),
    read,
};

fn file(path: &Path) -> Option<PathBuf> {
    let other = || found::told(path, &[".xml"], is_one).filter(|file| is_one(file));
    found::named(path, &["blocks.xml", "BlocksExchange.xml"]).or_else(other)
}

fn is_one(file: &Path) -> bool {
    whole::start_text(file, 4096).contains("<BlocksExchange")
}

fn read(path: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let file = file(path).ok_or_else(|| Error::malformed(path, "no BlocksExchange .xml is there"))?;
    let text = whole::text(&file)?;
    let document = xml::parse(&file, &text)?;
    let fault = |why: String| Error::malformed(&file, why);
    let groups: Vec<Node<'_, '_>> = xml::all(document.root_element(), "Photogroup").collect();
    let path_of = |photo: Node<'_, '_>| xml::text(photo, "ImagePath").unwrap_or_default().to_owned();
    let written: Vec<String> = groups.iter().flat_map(|group| xml::children(*group, "Photo")).map(path_of).collect();
    let mut settled = names::settled(&written, photographs)?.into_iter();
    let (mut frames, mut unposed) = (Vec::new(), Vec::new());
    for (at, group) in groups.into_iter().enumerate() {
        let mut camera = None;
        for (photo, name) in xml::children(group, "Photo").zip(&mut settled) {
            let fault = |why| fault(format!("photo {}: {why}", shown(&path_of(photo))));
            let axes = axes(group).map_err(fault)?;
            let Some(pose) = pose(photo, axes).map_err(fault)? else {
                unposed.push(name);
                continue;
            };
            let shared = match &camera {
                Some(camera) => Arc::clone(camera),
                None => Arc::new(lens(group, axes).map_err(|why| fault(format!("its photogroup {at}: {why}")))?),
            };
            camera = Some(Arc::clone(&shared));
            frames.push(Frame { name, camera: shared, pose });
        }
    }
    let (georeference, note) = system(document.root_element()).map_err(fault)?;
    Ok(Posed { frames, unposed, georeference, notes: note.into_iter().collect() })
}

/// Where on the earth the block lies, as the system of its coordinates says, or what is told of a system that is not known here;
/// neither where it names none, or one that is of nowhere.
///
/// # Errors
/// In words: coordinates in degrees.
fn system(root: Node<'_, '_>) -> Result<(Option<Georeference>, Option<String>), String> {
    let block = xml::child(root, "Block").unwrap_or(root);
    let id = xml::text(block, "SRSId").unwrap_or_default();
    let described = xml::all(root, "SRS").find(|srs| xml::text(*srs, "Id") == Some(id));
    let definition = described.and_then(|srs| xml::text(srs, "Definition")).unwrap_or("Local");
    match definition.parse().ok().or_else(|| Crs::of_definition(definition)) {
        Some(crs) if crs.is_geographic() => Err(format!(
            "its coordinates are of SRS {} ({crs}), in degrees, which no mesh has: export the block in the system of the mesh",
            shown(id)
        )),
        Some(crs) => Ok((Some(Georeference { crs: Some(crs), offset: [0.0; 3] }), None)),
        None if definition.starts_with("LOCAL_CS") || definition == "Local" => Ok((None, None)),
        None => {
            let (id, definition) = (shown(id), shown(definition));
            Ok((None, Some(format!("coordinates are of the file's SRS {id}, {definition}, which is not known here"))))
        }
    }
}

/// From the axes of a photogroup's cameras to ours.
fn axes(group: Node<'_, '_>) -> Result<DMat3, String> {
    let named = xml::text(group, "CameraOrientation").unwrap_or("XRightYDown");
    let towards = |way: &str| {
        let ways = [("Right", DVec3::X), ("Left", DVec3::NEG_X), ("Down", DVec3::Y), ("Up", DVec3::NEG_Y)];
        ways.into_iter().find(|(name, _)| *name == way).map(|(_, axis)| axis)
    };
    let parts = named.strip_prefix('X').and_then(|rest| rest.split_once('Y'));
    let found = parts.and_then(|(x, y)| Some((towards(x)?, towards(y)?))).filter(|(x, y)| x.dot(*y) == 0.0);
    let (x, y) = found.ok_or_else(|| format!("its CameraOrientation is {}; as XRightYDown is needed", shown(named)))?;
    Ok(DMat3::from_cols(x, y, x.cross(y)))
}

/// The pose of a photo; `None` where it has none.
fn pose(photo: Node<'_, '_>, axes: DMat3) -> Result<Option<Pose>, String> {
    let Some(pose) = xml::child(photo, "Pose") else { return Ok(None) };
    let (Some(rotation), Some(centre)) = (xml::child(pose, "Rotation"), xml::child(pose, "Center")) else {
        return Ok(None);
    };
    if xml::child(rotation, "M_00").is_none() {
        return Err("its rotation is not given as a matrix, M_00 to M_22: export rotation matrices".to_owned());
    }
    let mut matrix = [0.0; 9];
    for (at, element) in matrix.iter_mut().enumerate() {
        *element = xml::a_number(rotation, &format!("M_{}{}", at / 3, at % 3))?;
    }
    let centre = DVec3::new(xml::a_number(centre, "x")?, xml::a_number(centre, "y")?, xml::a_number(centre, "z")?);
    posed::at_centre(axes * posed::rows(matrix), centre).map(Some)
}

/// The camera of a photogroup.
fn lens(group: Node<'_, '_>, axes: DMat3) -> Result<Camera, String> {
    let size = xml::child(group, "ImageDimensions").ok_or("<ImageDimensions> is needed")?;
    let (width, height) = (xml::whole_number(size, "Width")?, xml::whole_number(size, "Height")?);
    let side = |pixels: u64| u32::try_from(pixels).map_err(|_| format!("the image has a side of {pixels} pixels"));
    let sides = DVec2::new(side(width)?.into(), side(height)?.into());
    if let Some(kind) = xml::text(group, "CameraModelType").filter(|kind| *kind != "Perspective") {
        return Err(format!("its CameraModelType is {}; Perspective is read", shown(kind)));
    }
    let focal = match xml::maybe_number(group, "FocalLengthPixels")? {
        Some(pixels) => pixels,
        None => xml::a_number(group, "FocalLength")? * sides.max_element() / xml::a_number(group, "SensorSize")?,
    };
    let aspect = xml::maybe_number(group, "AspectRatio")?.unwrap_or(1.0);
    let skew = xml::maybe_number(group, "Skew")?.unwrap_or_default();
    terms::negligible("Skew", skew, skew * 0.5 * sides.y / focal)?;
    let centre = match xml::child(group, "PrincipalPoint") {
        Some(point) => DVec2::new(xml::a_number(point, "x")?, xml::a_number(point, "y")?),
        None => sides * 0.5,
    };
    let distortion = match xml::child(group, "Distortion") {
        Some(of) => {
            let term = |name| xml::maybe_number(of, name).map(Option::unwrap_or_default);
            let tangential = [term("P2")?, term("P1")?];
            Distortion { tangential, ..Distortion::radial([term("K1")?, term("K2")?, term("K3")?]) }
        }
        None => Distortion::default(),
    };
    if axes != DMat3::IDENTITY && distortion.tangential != [0.0; 2] {
        return Err("it has P1 and P2 with a CameraOrientation of its own, whose meaning is not known".to_owned());
    }
    let lens = Lens::new(DVec2::new(focal, focal * aspect), centre, Projection::Perspective(distortion))?;
    Camera::new(width, height, lens)
}
