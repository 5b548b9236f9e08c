//! The `.xmp` of an image. Values of RealityCapture's namespace stand in attributes or in elements.

use std::path::{Path, PathBuf};
use std::sync::Arc;

use glam::{DVec2, DVec3};
use roxmltree::Node;

use super::lens;
use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::images::Size;
use crate::codec::poses::format::Posed;
use crate::codec::poses::photographs::Photographs;
use crate::codec::poses::{names, posed, terms, whole, words, xml};
use crate::scene::camera::{Camera, Distortion, Projection};
use crate::scene::frame::Frame;
use crate::scene::pose::Pose;

/// Whether a file is RealityCapture's: cameras and programs that develop photographs write `.xmp` files too.
pub(super) fn is_one(file: &Path) -> bool {
    whole::start_text(file, 1 << 16).contains("capturingreality.com")
}

/// Reads those files of a folder that are RealityCapture's. Images whose file has no pose are not registered.
///
/// # Errors
/// None that is RealityCapture's; a file that cannot be read, a lens that no lens of ours can say, an image whose size cannot be read.
pub(super) fn read(files: &[PathBuf], photographs: &dyn Photographs) -> Result<Posed> {
    let own: Vec<&PathBuf> = files.iter().filter(|file| is_one(file)).collect();
    let (Some(first), true) = (files.first(), own.is_empty()) else { return registered(&own, photographs) };
    let found = "it is not RealityCapture's: it names no namespace of capturingreality.com, and no .xmp beside it does";
    Err(Error::malformed(first, found))
}

fn registered(files: &[&PathBuf], photographs: &dyn Photographs) -> Result<Posed> {
    let written: Vec<String> =
        files.iter().map(|file| file.file_stem().unwrap_or_default().to_string_lossy().into_owned()).collect();
    let (mut frames, mut unposed) = (Vec::new(), Vec::new());
    for (file, name) in files.iter().zip(names::settled(&written, photographs)?) {
        let text = whole::text(file)?;
        let document = xml::parse(file, &text)?;
        let fault = |why| Error::malformed(file, why);
        let of = described(file, document.root())?;
        let Some(pose) = pose(of).map_err(fault)? else {
            unposed.push(name);
            continue;
        };
        let camera = camera(of, photographs.size(&name)?).map_err(fault)?;
        frames.push(Frame { name, camera: Arc::new(camera), pose });
    }
    Ok(Posed { frames, unposed, ..Posed::default() })
}

/// The element that says something of the camera.
fn described<'a, 'i>(file: &Path, root: Node<'a, 'i>) -> Result<Node<'a, 'i>> {
    let mut all = xml::all(root, "Description").filter(|node| xml::value(*node, "FocalLength35mm").is_some());
    all.next().ok_or_else(|| Error::malformed(file, "no rdf:Description in it has xcr:FocalLength35mm"))
}

fn pose(of: Node<'_, '_>) -> Result<Option<Pose>, String> {
    if xml::value(of, "Rotation").is_none() || xml::value(of, "Position").is_none() {
        return Ok(None);
    }
    let (rotation, centre) = (posed::rows(xml::numbers(of, "Rotation")?), xml::numbers(of, "Position")?);
    posed::at_centre(rotation, DVec3::from(centre)).map(Some)
}

fn camera(of: Node<'_, '_>, size: Size) -> Result<Camera, String> {
    let term = |name| xml::maybe_number(of, name).map(Option::unwrap_or_default);
    let pixels = f64::from(size.width.max(size.height));
    let skew = term("Skew")?;
    terms::negligible("Skew", skew, skew * pixels)?;
    let aspect = xml::maybe_number(of, "AspectRatio")?.unwrap_or(1.0);
    terms::negligible("AspectRatio", aspect, (aspect - 1.0) * pixels)?;
    let point = DVec2::new(term("PrincipalPointU")?, term("PrincipalPointV")?);
    lens::camera(size, xml::a_number(of, "FocalLength35mm")?, point, projection(of)?)
}

fn projection(of: Node<'_, '_>) -> Result<Projection, String> {
    // The name is written so.
    let text = xml::value(of, "DistortionCoeficients").or(xml::value(of, "DistortionCoefficients")).unwrap_or_default();
    let mut values = [0.0; 6];
    let mut found = words::Words::of(text);
    for value in &mut values {
        let Some(word) = found.word() else { break };
        *value = words::number(word, "DistortionCoeficients")?;
    }
    if let Some(more) = found.word() {
        return Err(format!("DistortionCoeficients go on with {}; at most six are known", shown(more)));
    }
    let [k1, k2, k3, k4, t1, t2] = values;
    let model = xml::value(of, "DistortionModel").unwrap_or("perspective");
    let only = |kept: usize| {
        (kept..6).try_for_each(|at| terms::none(&format!("DistortionCoeficients {}", at + 1), values[at]))
    };
    match model {
        "perspective" | "none" => only(0).map(|()| Projection::Pinhole),
        "brown3" | "brown4" => only(4).map(|()| Projection::Perspective(Distortion::radial([k1, k2, k3, k4]))),
        "brown3t2" | "brown4t2" => {
            let radial = Distortion::radial([k1, k2, k3, k4]);
            Ok(Projection::Perspective(Distortion { tangential: [t1, t2], ..radial }))
        }
        "division" => {
            let rational = [k1, 0.0, 0.0];
            only(1).map(|()| Projection::Inward(Distortion { rational, ..Distortion::default() }))
        }
        other => Err(format!(
            "its DistortionModel is {}; brown3, brown4, with t2 or not, and division are read",
            shown(other)
        )),
    }
}
