//! The format `micmac`: a folder `Ori-*`.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::DVec3;
use roxmltree::Node;

use super::lens::{self, CONVENTION, unknown};
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::poses::format::{PoseFormat, Posed, Target};
use crate::codec::poses::photographs::Photographs;
use crate::codec::poses::{found, names, posed, whole, xml};
use crate::scene::camera::Camera;
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// MicMac's orientations.
pub(crate) const MICMAC: PoseFormat = PoseFormat {
    name: "micmac",
    programs: "MicMac",
    target: Target::Folder,
    advice: "name the folder Ori-* that holds Orientation-*.xml",
    is_at: |path| !orientations(path).is_empty(),
    missing: |path| found::missing(path, !orientations(path).is_empty(), "must hold Orientation-*.xml"),
    read,
};

/// The start of an orientation's name.
const START: &str = "Orientation-";

fn orientations(folder: &Path) -> Vec<PathBuf> {
    let mut all = if folder.is_dir() { found::ending(folder, &[".xml"]) } else { Vec::new() };
    all.retain(|file| image_of(file).is_some());
    all
}

/// The image of an orientation.
fn image_of(file: &Path) -> Option<&str> {
    file.file_name()?.to_str()?.strip_prefix(START)?.strip_suffix(".xml").filter(|name| !name.is_empty())
}

fn read(folder: &Path, photographs: &dyn Photographs) -> Result<Posed> {
    let files = orientations(folder);
    let written: Vec<String> = files.iter().filter_map(|file| image_of(file)).map(str::to_owned).collect();
    let mut cameras: BTreeMap<PathBuf, Arc<Camera>> = BTreeMap::new();
    let mut frames = Vec::with_capacity(files.len());
    for (file, name) in files.iter().zip(names::settled(&written, photographs)?) {
        let text = whole::text(file)?;
        let document = xml::parse(file, &text)?;
        let fault = |why| Error::malformed(file, why);
        let (pose, calibration) = orientation(document.root()).map_err(fault)?;
        let calibration = folder.join(calibration);
        let camera = match cameras.get(&calibration) {
            Some(camera) => Arc::clone(camera),
            None => {
                let camera =
                    Arc::new(lens::read(&calibration).map_err(|why| why.doing(format!("image {}", shown(&name))))?);
                cameras.insert(calibration, Arc::clone(&camera));
                camera
            }
        };
        frames.push(Frame { name, camera, pose });
    }
    Ok(frames.into())
}

/// The pose of an orientation, and the name of its calibration's file, which lies beside it.
fn orientation<'a>(root: Node<'a, '_>) -> Result<(Pose, &'a str), String> {
    let of = xml::all(root, "OrientationConique").next().ok_or("no <OrientationConique> is in it")?;
    let outside = xml::child(of, "Externe").ok_or("<Externe> is needed")?;
    match xml::text(outside, "KnownConv") {
        Some(CONVENTION) => {}
        other => return Err(unknown(other.unwrap_or("not said"))),
    }
    if let Some(other) = xml::text(of, "TypeProj").filter(|kind| *kind != "eProjStenope") {
        return Err(format!("its TypeProj is {}; eProjStenope is read", shown(other)));
    }
    if let Some(affine) = xml::child(of, "OrIntImaM2C") {
        let parts = [("I00", [0.0, 0.0]), ("V10", [1.0, 0.0]), ("V01", [0.0, 1.0])];
        for (name, plain) in parts {
            if xml::numbers::<2>(affine, name)? != plain {
                return Err(format!(
                    "its image is moved by OrIntImaM2C ({name}), as scanned film is: that is not read"
                ));
            }
        }
    }
    let rotation = xml::child(outside, "ParamRotation").and_then(|node| xml::child(node, "CodageMatr"));
    let rotation = rotation.ok_or("its rotation is not given as a matrix (CodageMatr)")?;
    let rows: [[f64; 3]; 3] =
        [xml::numbers(rotation, "L1")?, xml::numbers(rotation, "L2")?, xml::numbers(rotation, "L3")?];
    let to_world = glam::DMat3::from_cols_array_2d(&rows).transpose();
    let centre = DVec3::from(xml::numbers::<3>(outside, "Centre")?);
    let calibration = xml::text(of, "FileInterne").ok_or("FileInterne, its calibration, is needed")?;
    let beside = calibration.rsplit(['/', '\\']).next().filter(|name| !name.is_empty() && *name != "..");
    let beside = beside.ok_or_else(|| format!("FileInterne is {}; a file's name is needed", shown(calibration)))?;
    Ok((posed::at_centre(to_world.transpose(), centre)?, beside))
}
