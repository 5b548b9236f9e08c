//! A calibration. With d from the distortion's centre, `image = CDist + d (1 + K1 |d|^2 + K2 |d|^4 + ..)`, all in pixels.

use std::path::Path;

use glam::DVec2;

use crate::base::shown::shown;
use crate::base::{Error, Result};
use crate::codec::poses::{terms, whole, words, xml};
use crate::scene::camera::{Camera, Distortion, Lens, Projection};

/// The one convention that is read.
pub(super) const CONVENTION: &str = "eConvApero_DistM2C";

/// What is said of a convention that is not read.
pub(super) fn unknown(convention: &str) -> String {
    format!("its convention is {}; {CONVENTION} is read", shown(convention))
}

/// Reads a calibration.
///
/// # Errors
/// A file that cannot be read; a distortion that no lens has; a parameter out of range.
pub(super) fn read(file: &Path) -> Result<Camera> {
    let text = whole::text(file)?;
    let document = xml::parse(file, &text)?;
    let root = document.root();
    let calibration = xml::all(root, "CalibrationInternConique").next();
    camera(calibration).map_err(|why| Error::malformed(file, why))
}

fn camera(calibration: Option<roxmltree::Node<'_, '_>>) -> Result<Camera, String> {
    let of = calibration.ok_or("no <CalibrationInternConique> is in it")?;
    if let Some(other) = xml::text(of, "KnownConv").filter(|conv| *conv != CONVENTION) {
        return Err(unknown(other));
    }
    let (point, focal) = (DVec2::from(xml::numbers::<2>(of, "PP")?), xml::a_number(of, "F")?);
    let size = xml::value(of, "SzIm").ok_or("SzIm is needed")?;
    let mut sides = words::Words::of(size);
    let (width, height) = (sides.number("SzIm")?, sides.number("SzIm")?);
    let mut terms = [0.0; 6];
    for distortion in xml::children(of, "CalibDistortion") {
        for model in distortion.children().filter(roxmltree::Node::is_element) {
            match model.tag_name().name() {
                "ModNoDist" => {}
                "ModRad" => radial(model, point, focal, &mut terms)?,
                other => {
                    let advice = "calibrate with RadialBasic, RadialStd or RadialExtended";
                    return Err(format!("its distortion is {other}, and no lens of gonio has it: {advice}"));
                }
            }
        }
    }
    let lens = Lens::new(DVec2::splat(focal), point, Projection::Perspective(Distortion::radial(terms)))?;
    Camera::new(width, height, lens)
}

/// Reads the radial terms, in units of the focal length.
fn radial(model: roxmltree::Node<'_, '_>, point: DVec2, focal: f64, into: &mut [f64; 6]) -> Result<(), String> {
    let about = DVec2::from(xml::numbers::<2>(model, "CDist")?);
    let written = xml::children(model, "CoeffDist");
    let mut power = 1.0;
    for (at, coefficient) in written.enumerate() {
        power *= focal * focal;
        let [value] = words::exactly(coefficient.text().unwrap_or_default(), "CoeffDist")?;
        match into.get_mut(at) {
            Some(to) => *to = value * power,
            None => terms::none(&format!("CoeffDist {}", at + 1), value)?,
        }
    }
    // A distortion about another point is no distortion about this one.
    let off = about.distance(point);
    if *into != [0.0; 6] && off > 0.01 {
        return Err(format!(
            "the lens has its distortion about CDist, {off:.2} pixels from PP, and no lens of gonio has it: calibrate with \
             RadialBasic (PPaEqPPs)"
        ));
    }
    Ok(())
}
