//! A sensor's lens. With x, y ideal and r2 = x^2 + y^2,
//!
//! ```text
//! x' = x (1 + k1 r2 + k2 r2^2 + ..) + p1 (r2 + 2 x^2) + 2 p2 x y      y' likewise with p2, p1
//! u  = w / 2 + cx + x' f + x' b1 + y' b2                              v = h / 2 + cy + y' f
//! ```

use glam::DVec2;
use roxmltree::Node;

use crate::base::shown::shown;
use crate::codec::poses::{terms, xml};
use crate::scene::camera::{Camera, Distortion, Lens, Projection};

/// The camera of a `<sensor>`.
///
/// # Errors
/// In words: a type that is no lens, a term that no lens has, a parameter out of range.
pub(super) fn camera(sensor: Node<'_, '_>) -> Result<Camera, String> {
    // Of two calibrations, the adjusted one counts; the other is where the adjustment began.
    let all = || xml::children(sensor, "calibration");
    let adjusted = all().find(|calibration| calibration.attribute("class") == Some("adjusted"));
    let calibration = adjusted.or_else(|| all().next());
    let size = |of: Node<'_, '_>| -> Result<Option<(u64, u64)>, String> {
        let Some(size) = xml::child(of, "resolution") else { return Ok(None) };
        Ok(Some((xml::whole_number(size, "width")?, xml::whole_number(size, "height")?)))
    };
    let own = calibration.map(size).transpose()?.flatten();
    let (width, height) = own.map_or_else(|| size(sensor), |own| Ok(Some(own)))?.ok_or("<resolution> is needed")?;
    let side = |pixels: u64| u32::try_from(pixels).map_err(|_| format!("the image has a side of {pixels} pixels"));
    let half = DVec2::new(side(width)?.into(), side(height)?.into()) * 0.5;
    let lens = match calibration {
        Some(calibration) => calibrated(sensor, calibration, half)?,
        None => by_focal_length(sensor, half)?,
    };
    Camera::new(width, height, lens)
}

fn calibrated(sensor: Node<'_, '_>, calibration: Node<'_, '_>, half: DVec2) -> Result<Lens, String> {
    let term = |name| xml::maybe_number(calibration, name).map(Option::unwrap_or_default);
    let f = xml::a_number(calibration, "f")?;
    let radial = Distortion::radial([term("k1")?, term("k2")?, term("k3")?, term("k4")?]);
    let distortion = Distortion { tangential: [term("p2")?, term("p1")?], ..radial };
    terms::none("p3", term("p3")?)?;
    terms::none("p4", term("p4")?)?;
    let b2 = term("b2")?;
    terms::negligible("b2", b2, b2 * half.y / f)?;
    let kind = calibration.attribute("type").or(sensor.attribute("type")).unwrap_or("frame");
    let projection = match kind {
        "frame" => Projection::Perspective(distortion),
        "fisheye" | "equidistant_fisheye" => Projection::Equidistant(distortion),
        other => return Err(format!("it is {}, and no lens of gonio is; frame and fisheye are read", shown(other))),
    };
    Lens::new(DVec2::new(f + term("b1")?, f), half + DVec2::new(term("cx")?, term("cy")?), projection)
}

/// The lens of a sensor that was never calibrated: its focal length, in millimetres.
fn by_focal_length(sensor: Node<'_, '_>, half: DVec2) -> Result<Lens, String> {
    let property = |name| {
        let mut all = xml::children(sensor, "property").filter(|property| property.attribute("name") == Some(name));
        all.next().map(|property| xml::a_number(property, "value")).transpose()
    };
    match (property("focal_length")?, property("pixel_width")?) {
        (Some(focal), Some(pixel)) if pixel > 0.0 => Lens::new(DVec2::splat(focal / pixel), half, Projection::Pinhole),
        _ => Err("it has neither a calibration nor a focal length and a pixel width".to_owned()),
    }
}

/// Which band of a multispectral sensor a `<sensor>` is: 0 for the first, or the only one.
pub(super) fn band(sensor: Node<'_, '_>) -> Result<u64, String> {
    if sensor.attribute("layer_index").is_some() {
        return xml::whole_number(sensor, "layer_index");
    }
    let mut all =
        xml::children(sensor, "property").filter(|property| property.attribute("name") == Some("layer_index"));
    all.next().map_or(Ok(0), |property| xml::whole_number(property, "value"))
}
